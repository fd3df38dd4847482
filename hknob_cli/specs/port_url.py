"""The name or URL of a serial port: those that lead to a device, and to nothing else."""

SCHEMES = ("socket", "rfc2217", "loop")


def url_fault(url: str) -> str:
    """What is wrong with it; empty if nothing is. Other schemes of pyserial write files, or load code by name."""
    scheme, sign, _ = url.partition("://")
    if not sign or scheme.lower() in SCHEMES:
        return ""
    return f"must be a port's name, or begin with {', '.join(f'{one}://' for one in SCHEMES)}"
