#include "tests/bench/peers.h"

#include <dlfcn.h>
#include <filesystem>

namespace trephine::bench {

const PeerSet& peers() {
  static const PeerSet none;
  static const PeerSet* const found = []() -> const PeerSet* {
    // Beside the program; it stays loaded.
    std::error_code error;
    const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
    const std::string path = (program.parent_path() / "libtrephine-peers.so").string();
    void* library = error ? nullptr : dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    void* entry = library ? dlsym(library, "trephine_peer_set") : nullptr;
    return entry ? reinterpret_cast<const PeerSet* (*)()>(entry)() : nullptr;
  }();
  return found ? *found : none;
}

}  // namespace trephine::bench
