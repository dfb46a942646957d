#include "apps/bench/peers.h"

#include "apps/bench/bench_library.h"

namespace trephine::bench {

const PeerSet& peers() {
  static const PeerSet none;
  static const PeerSet* const found = [] {
    const auto entry = find_in_library<const PeerSet* (*)()>("libtrephine-peers.so", "trephine_peer_set");
    return entry ? entry() : nullptr;
  }();
  return found ? *found : none;
}

}  // namespace trephine::bench
