"""Stage sweep: every limit cycle of a grid."""
