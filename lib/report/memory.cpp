#include "lib/report/memory.h"

#include <malloc.h>
#include <sys/resource.h>

#include <exception>
#include <fstream>
#include <string>
#include <thread>

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

}  // namespace lanc
