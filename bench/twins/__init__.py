"""Twin scenes: each is described once and built for Sheaf, Cycles and LuxCore."""
