// Fixture for session tests: a small plate of bone, a burr, a folder, and the result of a replay.
#pragma once

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>
#include <memory>
#include <string>

#include "apps/bench/scenes/scenes.h"
#include "apps/bench/scenes/scratch.h"
#include "haptics/methods/methods.h"
#include "haptics/proxy/implicit_proxy.h"
#include "modules/drilling/burr.h"
#include "sim/drivers/lockstep.h"
#include "sim/drivers/replay.h"
#include "sim/session/compression.h"
#include "sim/session/session_writer.h"

namespace trephine::sim {

using glm::dvec3;
namespace fs = std::filesystem;

inline haptics::TouchScene small_bone() {
  data_tools::PhantomOptions o;
  o.size = glm::ivec3(48);
  o.spacing_mm = dvec3(0.5);
  o.psf_sigma_voxels = 1;
  o.parameters = {{"thickness", 4}, {"angle", 10}};
  return scenes::phantom_scene("plate", o);
}

inline const drilling::Burr k_burr{3, 60, 40, false};

inline std::vector<HandSpec> burr_spec() { return {HandSpec(drilling::burr(k_burr))}; }

inline const Catalogue& drilling_catalogue() {
  static const drilling::Drilling drilling;
  static const Catalogue all({&drilling});
  return all;
}

/// A temporary folder, which the destructor deletes.
struct Folder : scenes::Scratch {
  std::string file(const char* name) const { return (path / name).string(); }
};

/// A scene, a method and a burr, with which a test runs.
struct Bench {
  haptics::TouchScene scene = small_bone();
  haptics::ImplicitProxy method;
  drilling::Burr burr{k_burr};
  Bench() { EXPECT_FALSE(method.prepare(scene).has_value()); }
  SessionHeader header(double rate = 1000) {
    haptics::ServoOptions options;
    options.rate_hz = rate;
    SessionHeader h = describe_scene(scene, method, options, burr_spec());
    h.program = "test";
    h.case_name = "small bone";
    return h;
  }
  std::unique_ptr<SessionWriter> writer(const std::string& path, double rate = 1000,
                                        const WriterOptions& options = {}) {
    auto result = SessionWriter::create(path, header(rate), scene.base, drilling_catalogue(), options);
    EXPECT_TRUE(result.is_ok()) << (result ? "" : result.error().message());
    return std::move(result).value();
  }
};

/// Writes a session without an end: its header, and one block of the log.
inline void write_session(const std::string& path, const SessionHeader& header, const std::string& log) {
  std::string bytes(k_session_magic);
  const std::uint32_t layout[2] = {k_session_layout, 0};
  bytes.append(reinterpret_cast<const char*>(layout), sizeof layout);
  std::uint64_t number = 0;
  for (const auto& [kind, payload] :
       {std::pair(BlockKind::header, encode(header)), std::pair(BlockKind::log, compress(log))}) {
    const BlockHead head{k_block_magic, static_cast<std::uint32_t>(kind), number++, 0, payload.size()};
    const std::uint64_t check = block_checksum(head, payload);
    bytes.append(reinterpret_cast<const char*>(&head), sizeof head);
    bytes += payload;
    bytes.append(reinterpret_cast<const char*>(&check), sizeof check);
  }
  std::ofstream(path, std::ios::binary) << bytes;
}

/// Result of a complete replay.
struct Verdict {
  std::optional<Mismatch> mismatch;
  Replay::Counts counts;
  std::uint64_t hash = 0, state = 0;
  double removed = 0, tool_radius = 0;
  std::string error;
};

/// Replays a session, by default on the small bone, with the session's own method.
inline Verdict replay(const std::string& path, std::shared_ptr<const volume::Volume> base = nullptr,
                      const Catalogue& catalogue = drilling_catalogue()) {
  Verdict v;
  auto opened = SessionReader::open(path, catalogue);
  if (!opened) return v.error = opened.error().message(), v;
  SessionReader& session = opened.value();
  v.tool_radius = session.header().hands[0].tool->radius();
  const auto opened_replay = Replay::open(session, base ? base : small_bone().base);
  if (!opened_replay) return v.error = opened_replay.error().message(), v;
  Replay& run = *opened_replay.value();
  for (;;) {
    const auto stepped = run.step();
    if (!stepped) return v.error = stepped.error().message(), v;
    if (!stepped.value()) break;
  }
  v.mismatch = run.mismatch();
  v.counts = run.counts();
  v.hash = run.engine().version()->content_hash();
  v.state = run.engine().state().hash();
  v.removed = run.engine().removed_mm3();
  return v;
}

inline void expect_same(const Verdict& v) {
  EXPECT_EQ(v.error, "");
  if (v.mismatch)
    ADD_FAILURE() << v.mismatch->what << " at tick " << v.mismatch->tick << ": recorded "
                  << v.mismatch->recorded << ", replayed " << v.mismatch->replayed;
}

/// Returns the path of a hand that drills up and down over the plate for `seconds` (s).
inline haptics::PosePath drilling_path(double seconds) {
  std::vector<haptics::PosePath::Sample> samples;
  for (double t = 0; t < seconds; t += 0.05) {
    const double phase = std::fmod(t, 0.6);
    const double z = phase < 0.1 ? 5 - 20 * phase : phase < 0.45 ? 3 - 12 * (phase - 0.1) : 5;
    samples.push_back(
        {t, {{4 * std::sin(3 * t), 3 * std::cos(2 * t), z}, {1, 0, 0, 0}, phase > 0.08 && phase < 0.5}});
  }
  return haptics::PosePath::from_samples(samples, "test").value();
}

/// Records a lockstep run with undos. Returns the hash of the final version.
inline std::uint64_t record_lockstep(const std::string& path, int ticks) {
  Bench bench;
  auto writer = bench.writer(path);
  Lockstep run(bench.scene, bench.method, drilling::burr(bench.burr), {}, 1000, writer.get());
  const haptics::PosePath request = drilling_path(10);
  for (int i = 0; i < ticks; ++i) {
    run.step(request.at(1e-3 * i));
    if (i % 500 == 250) run.undo();
  }
  EXPECT_FALSE(writer->finish(run.engine()));
  return run.engine().version()->content_hash();
}

}  // namespace trephine::sim
