#include "lib/report/memory.h"

#include <malloc.h>
#include <sys/resource.h>

#include <algorithm>
#include <exception>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "lib/report/timing.h"

namespace lanc {

std::int64_t heap_bytes() {
  const auto info = ::mallinfo2();
  return static_cast<std::int64_t>(info.uordblks + info.hblkhd);
}

std::int64_t heap_bytes_of(const std::function<void()>& bind) {
  std::int64_t bytes = 0;
  std::exception_ptr error;
  std::thread([&] {
    const std::int64_t before = heap_bytes();
    try {
      bind();
    } catch (...) {
      error = std::current_exception();
    }
    bytes = heap_bytes() - before;
  }).join();
  if (error) std::rethrow_exception(error);
  return bytes;
}

std::int64_t peak_bytes() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::int64_t>(usage.ru_maxrss) * 1024;
}

std::int64_t available_bytes() {
  std::ifstream in("/proc/meminfo");
  for (std::string line; std::getline(in, line);)
    if (line.rfind("MemAvailable:", 0) == 0) return std::stoll(line.substr(13)) * 1024;
  return 0;
}

double memory_bandwidth() {
  constexpr std::size_t count = std::size_t{1} << 23;  // 64 MB an array
  std::vector<double> a(count, 0.0), b(count, 1.0), c(count, 2.0);
  double best = 0;
  for (int r = 0; r < 5; ++r) {
    const double begin = thread_seconds();
    for (std::size_t i = 0; i < count; ++i) a[i] = b[i] + 0.5 * c[i];
    const double seconds = thread_seconds() - begin;
    b.swap(a);  // the next round reads what this one wrote, so that none is left out
    best = std::max(best, 3.0 * sizeof(double) * double(count) / seconds);
  }
  return best;
}

}  // namespace lanc
