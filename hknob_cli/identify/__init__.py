"""Identification: from recorded motion to inertia, damping and stiffness, with how sure they are."""
