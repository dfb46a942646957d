// Entry point of the library of peers.
#include "apps/bench/peers.h"

extern "C" const trephine::bench::PeerSet* trephine_peer_set() {
  using namespace trephine::bench;
  static const PeerSet set{
      {
#ifdef TREPHINE_HAS_EMBREE
          embree_peer(),
#endif
#ifdef TREPHINE_HAS_OPENVDB
          openvdb_peer(),
#endif
#ifdef TREPHINE_HAS_FCL
          fcl_peer(),
#endif
      },
#ifdef TREPHINE_HAS_NANOVDB
      TREPHINE_HAS_NANOVDB,
      make_nano_grid,
      free_nano_grid,
      run_nano_rays,
#else
      "",
      nullptr,
      nullptr,
      nullptr,
#endif
#ifdef TREPHINE_HAS_OPENVDB
      csg_ticks,
#else
      nullptr,
#endif
#ifdef TREPHINE_HAS_ITK_GDCM
      gdcm_scan,
      itk_read,
#else
      nullptr,
      nullptr,
#endif
#ifdef TREPHINE_HAS_ITK_FLOOD
      itk_flood,
      itk_components,
#else
      nullptr,
      nullptr,
#endif
#ifdef TREPHINE_HAS_EMBREE
      embree_build_ms,
      embree_images,
#else
      nullptr,
      nullptr,
#endif
#ifdef TREPHINE_HAS_FCL
      fcl_collide,
#else
      nullptr,
#endif
#ifdef TREPHINE_HAS_OPENVDB
      openvdb_lookups,
#endif
  };
  return &set;
}
