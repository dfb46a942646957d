// Matter: what an object consists of, for X-rays, sections and pictures.
#pragma once

#include <cstdint>
#include <string_view>

namespace trephine::volume {

/// `scenery` is displayed and can be touched, but is in no X-ray and no section.
enum class Matter : std::uint8_t { bone, titanium, steel, soft_tissue, scenery };
inline constexpr std::string_view k_matters[] = {"bone", "titanium", "steel", "soft-tissue", "scenery"};

constexpr bool is_metal(Matter matter) noexcept {
  return matter == Matter::titanium || matter == Matter::steel;
}

}  // namespace trephine::volume
