"""Work spread over processes and machines: runs of numbered items, whose results come back in any order."""
