int* planted() { return new int(3); }
