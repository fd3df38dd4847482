"""The pipeline: steps that run in the order of their inputs, and only where something has changed.

- `build` a stage and its files, as pytask's protocols want them; pytask asked, its answer read
- `verify` whether files are as they were written
- `fresh` whether there is anything to do, without loading it
- `one_claim` the stages that one claim of its page needs, and the verdict
- `steps` from a pipeline's plan to stages with their files, and what each has found
- `side_by_side` stages that need nothing of one another, made by several processes

A pipeline's record is pytask's. Steps are nodes with the digest of their content: spec files, what the pipeline sets,
results of other stages, versions of the program. pytask orders them, skips, explains, and journals each as it ends, so
that a kill costs the steps under way at most; a stage that had already written its files, beside others or just before
the kill, finds them up to date by their provenance. After a run that ended well, `pipeline.json` beside `pytask.lock`
lets the next run see that nothing has changed without loading either. Provenance names a pipeline's inputs by stage
(`{from: grid}`) and digest, never by path, so that the same work gives the same bytes anywhere. Independent stages run
in no fixed order.
"""
