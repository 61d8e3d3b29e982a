// The cores this process may use, one at a time.
#pragma once

#include <sched.h>

#include <vector>

namespace lanc {

/// Cores the scheduler may give the calling thread; none where it does not say.
inline std::vector<int> own_cores() {
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  std::vector<int> cores;
  if (sched_getaffinity(0, sizeof allowed, &allowed) != 0) return cores;
  for (int k = 0; k < CPU_SETSIZE; ++k)
    if (CPU_ISSET(k, &allowed)) cores.push_back(k);
  return cores;
}

/// Keeps the calling thread on one core while it lives. Threads made meanwhile stay there for good.
class OnCore {
 public:
  explicit OnCore(int core) {
    sched_getaffinity(0, sizeof before_, &before_);
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(core, &one);
    sched_setaffinity(0, sizeof one, &one);
  }
  ~OnCore() { sched_setaffinity(0, sizeof before_, &before_); }
  OnCore(const OnCore&) = delete;
  OnCore& operator=(const OnCore&) = delete;

 private:
  cpu_set_t before_;
};

}  // namespace lanc
