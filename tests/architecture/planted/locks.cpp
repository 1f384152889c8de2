#include <mutex>
std::mutex mutex;
void planted() { mutex.lock(); }
