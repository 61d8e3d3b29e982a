// Memory a formulation takes, as the C library's allocator sees it: operator new and malloc of other libraries alike.
#pragma once

#include <cstdint>
#include <functional>

namespace lanc {

/// Bytes on the heap now (mallinfo2: blocks in use, large mapped ones included), headers of blocks included.
std::int64_t heap_bytes();

/// Bytes more on the heap after `bind` than before. It runs in a thread of its own, whose block cache is empty; small
/// blocks it freed meanwhile may still count (at most 7 of a size below 1 kB). 0 under the address sanitizer, which
/// replaces the allocator. What `bind` made must outlive it. Exceptions come through.
std::int64_t heap_bytes_of(const std::function<void()>& bind);

/// The most memory this process has held so far, bytes (resident set).
std::int64_t peak_bytes();

/// Bytes of memory this process may still take without swapping, as the system estimates.
std::int64_t available_bytes();

/// Bytes a second that one core moves between memory and registers: a = b + s c on arrays far larger than its caches,
/// 24 bytes an element, the best of five times (McCalpin's STREAM triad). Takes half a second.
double memory_bandwidth();

}  // namespace lanc
