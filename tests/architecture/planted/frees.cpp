void planted(int* p) { delete p; }
