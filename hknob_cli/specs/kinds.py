"""Every kind of spec, declared once: commands, schemas, messages and completion use it. Imports nothing."""

STAGES = ("sysid", "sweep", "dfa", "predict", "remedies", "design", "hw-run", "bench", "report")
PIPELINE = "pipeline"
CLAIMS = "claims"  # a ledger, which names no kind
SPECS = (*STAGES, PIPELINE)  # what `kind:` may say
SCHEMAS = (*SPECS, CLAIMS)
