#include "experiments/peers/peer.h"

#include <algorithm>
#include <tuple>

namespace lanc::peers {
namespace {

std::vector<PeerInfo>& list() {
  static std::vector<PeerInfo> all;  // made when the first registration asks for it
  return all;
}

}  // namespace

std::span<const PeerInfo> registered_peers() { return list(); }

PeerRegistration::PeerRegistration(const PeerInfo& info) {
  list().push_back(info);
  std::sort(list().begin(), list().end(),
            [](const PeerInfo& a, const PeerInfo& b) { return std::tie(a.name, a.task) < std::tie(b.name, b.task); });
}

}  // namespace lanc::peers
