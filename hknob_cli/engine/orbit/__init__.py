"""What one period of an orbit amounts to, hold by hold, in counts and samples."""
