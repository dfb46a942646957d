// bench stability: random attacks, stiffness maps and energies.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "apps/bench/attack.h"
#include "apps/bench/commands/bench_commands.h"
#include "apps/bench/stability.h"
#include "apps/view/chart.h"
#include "data-tools/files/atomic_file.h"
#include "haptics/methods/methods.h"

namespace trephine::bench {

using namespace cli;

namespace {

/// One map: stiffness of the simulated device as dots, theory as lines.
view::Chart stiffness_chart(const std::vector<bench::StiffnessRow>& rows, const std::string& what,
                            const char* title) {
  view::Chart chart{title, "servo rate (Hz)", "stiffness (N/mm)", true, true, {}};
  std::size_t color = 0;
  struct Loop {
    double alpha;
    int delay;
    bool has_encoder;
    const char* name;
  };
  for (const auto& [alpha, delay, has_encoder, name] :
       {Loop{1, 0, false, "raw"}, Loop{0.3, 0, false, "smoothed, alpha 0.3 at 1 kHz"},
        Loop{1, 2, false, "two ticks late"}, Loop{1, 0, true, "encoder 0.02 mm, friction 0.02 N"}}) {
    view::ChartSeries dots{"", {}, {}, false, view::chart_color(color), 9};
    view::ChartSeries theory{name, {}, {}, true, view::chart_color(color), 2},
        rule{std::string(name) + ", rule of thumb", {}, {}, true, view::chart_color(color), 1.2f, true};
    ++color;
    for (const bench::StiffnessRow& row : rows) {
      if (row.what != what || row.alpha != alpha || std::lround(row.delay_s * row.rate_hz) != delay ||
          (row.encoder_mm > 0) != has_encoder)
        continue;
      dots.x.push_back(row.rate_hz), dots.y.push_back(row.simulated);
      if (row.surface != "wall") continue;
      theory.x.push_back(row.rate_hz), theory.y.push_back(row.theory);
      rule.x.push_back(row.rate_hz), rule.y.push_back(row.rule);
    }
    if (dots.x.empty()) continue;
    if (color == 1) dots.name = "simulated: wall, sphere, 3 mm burr";
    chart.series.push_back(theory);
    if (what != "passive for any hand") chart.series.push_back(rule);
    chart.series.push_back(dots);
  }
  return chart;
}

}  // namespace

Status bench_stability(const BenchArguments& arguments, Outcome& outcome) {
  if (arguments.steps < 1000 || arguments.steps > 10'000'000'000)
    return Error{.what = "the number of steps is out of range",
                 .where = "--steps",
                 .found = std::to_string(arguments.steps),
                 .expected = "1000 to 10000000000"};
  bench::AttackOptions options;
  options.steps = arguments.steps;
  if (!arguments.source.empty()) {
    auto opened = workbench::open_touch(arguments.source, {}, terminal_listener());
    if (!opened) return opened.error();
    options.more.emplace_back(opened.value().source.written_name(), opened.value().scene);
  }
  if (!arguments.output.empty())
    if (Status error = data_tools::make_folder(arguments.output)) return error;
  if (!arguments.only.empty()) {
    for (const haptics::MethodInfo& info : haptics::method_catalogue())
      if (std::string(info.name).find(arguments.only) != std::string::npos)
        options.methods.emplace_back(info.name);
    if (options.methods.empty())
      return Error{.what = "unknown method",
                   .where = "--only",
                   .found = arguments.only,
                   .expected = "a part of one of these names: " + haptics::method_names()};
  }
  ProgressLine progress("random motion");
  bool is_stopped = false;
  options.progress = [&](double share) { return !(is_stopped = !progress(share)); };
  const std::vector<bench::AttackRow> attacks = bench::run_attack(options);
  if (is_stopped) return interrupted("the attack");
  const std::vector<bench::StiffnessRow> maps = bench::run_stiffness_maps(options.progress);
  if (is_stopped) return interrupted("the maps");
  const std::vector<bench::EnergyRow> energies = bench::run_energy_test();
  // An hour of simulated contact; a minute if fewer than a million steps were requested.
  const bench::SoakRow soak = bench::run_contact_soak(
      options.steps >= 1'000'000 ? 3'600'000 : bench::SoakRow::k_early, options.progress);
  if (is_stopped) return interrupted("the contact test");

  long failures = 0, steps = 0;
  std::string csv =
      "method,scene,steps,contacts,fall_throughs,judged_by_shape,too_deep,buried,not_finite,fastest_mm_s\n";
  for (const bench::AttackRow& row : attacks) {
    failures += row.fall_throughs + row.too_deep + row.not_finite, steps += row.steps;
    std::string scene = row.scene;
    std::replace(scene.begin(), scene.end(), ',', ';');
    csv += format_text("%s,%s,%ld,%ld,%ld,%ld,%ld,%ld,%ld,%.0f\n", row.method.c_str(), scene.c_str(),
                       row.steps, row.contacts, row.fall_throughs, row.judged_by_shape, row.too_deep,
                       row.buried, row.not_finite, row.fastest_mm_s);
    outcome.json["attacks"].push_back({{"method", row.method},
                                       {"scene", row.scene},
                                       {"steps", row.steps},
                                       {"contacts", row.contacts},
                                       {"fall_throughs", row.fall_throughs},
                                       {"judged_by_shape", row.judged_by_shape},
                                       {"too_deep", row.too_deep},
                                       {"buried", row.buried},
                                       {"not_finite", row.not_finite},
                                       {"fastest_mm_s", row.fastest_mm_s}});
  }
  Json table = outcome.json["attacks"];
  for (Json& row : table)  // a scene without contact was not tested
    if (row["contacts"] == 0) row["fall_throughs"] = row["too_deep"] = row["buried"] = nullptr;
  outcome.print_table(table,
                      "method = {method} | scene = {scene} | steps = {steps} | contacts = {contacts} | "
                      "fell = {fall_throughs} | too deep = {too_deep} | buried = {buried}");
  outcome.print(
      "{steps} steps at up to 10 m/s, with cuts and undos at the tool: {failures} failures (fell through, too deep "
      "or not finite)",
      {{"steps", steps}, {"failures", failures}});
  outcome.json["soak"] = {{"steps", soak.steps},
                          {"contacts", soak.contacts},
                          {"not_finite", soak.not_finite},
                          {"drift_mm", soak.drift_mm},
                          {"max_generated_nmm", soak.max_generated},
                          {"frictionless_steps", soak.frictionless_steps},
                          {"frictionless_contacts", soak.frictionless_contacts},
                          {"hash", format_text("%016llx", static_cast<unsigned long long>(soak.hash))}};
  outcome.print(
      "{minutes:.1f} minutes of simulated contact: proxy drift {soak/drift_mm:.1e} mm, hash {soak/hash}; "
      "without friction ({frictionless:.1f} minutes, {share:.0%} in contact) energy generated "
      "{soak/max_generated_nmm:.4f} N mm at most",
      {{"minutes", static_cast<double>(soak.steps) / 60e3},
       {"frictionless", static_cast<double>(soak.frictionless_steps) / 60e3},
       {"share", static_cast<double>(soak.frictionless_contacts) /
                     static_cast<double>(std::max(1L, soak.frictionless_steps))}});
  std::string map_csv = "surface,what,rate_hz,alpha,delay_s,coulomb_n,encoder_mm,simulated,theory,rule\n";
  double worst = 0, least = 1e300;
  for (const bench::StiffnessRow& row : maps) {
    // With an encoder, theory gives a guaranteed stiffness. The largest stiffness in the simulation may
    // exceed it.
    const double off = std::abs(row.simulated / row.theory - 1);
    if (row.encoder_mm == 0 && !(off <= worst)) worst = off;
    if (row.encoder_mm > 0) least = std::min(least, row.simulated / row.theory);
    map_csv += format_text("%s,%s,%g,%g,%g,%g,%g,%.4f,%.4f,%.4f\n", row.surface.c_str(), row.what.c_str(),
                           row.rate_hz, row.alpha, row.delay_s, row.coulomb_n, row.encoder_mm, row.simulated,
                           row.theory, row.rule);
    outcome.json["stiffness"].push_back({{"surface", row.surface},
                                         {"what", row.what},
                                         {"rate_hz", row.rate_hz},
                                         {"alpha", row.alpha},
                                         {"delay_s", row.delay_s},
                                         {"coulomb_n", row.coulomb_n},
                                         {"encoder_mm", row.encoder_mm},
                                         {"simulated", row.simulated},
                                         {"theory", row.theory},
                                         {"rule", row.rule}});
  }
  outcome.print(
      "largest stiffness, 250 Hz to 10 kHz: within {worst:.1%} of theory; with an encoder and friction, at "
      "least {least:.3f} times the stiffness that theory guarantees",
      {{"worst", worst}, {"least", least}});
  table = Json::array();
  for (const bench::EnergyRow& row : energies) {
    outcome.json["energy"].push_back({{"surface", row.surface},
                                      {"contact_share", row.contact_share},
                                      {"contact_share_with_controller", row.contact_share_with_controller},
                                      {"max_generated", row.max_generated},
                                      {"max_generated_with_controller", row.max_generated_with_controller},
                                      {"stiffness_over_bound", row.stiffness_over_bound},
                                      {"delay_ticks", row.delay_ticks},
                                      {"balance_without_controller", row.balance_without_controller},
                                      {"balance_with_controller", row.balance_with_controller},
                                      {"most_work_with_controller", row.most_work_with_controller},
                                      {"share_limited_by_controller", row.share_cut},
                                      {"least_stiffness_factor", row.force_scale}});
    table.push_back(outcome.json["energy"].back());
    table.back()["most_work"] = row.most_work;
  }
  outcome.print("energy, N mm:");
  outcome.print_table(
      table,
      "surface = {surface} | K/bound = {stiffness_over_bound:.1f} | delay = {delay_ticks} | "
      "generated without controller = {max_generated:.3f} | generated with controller = {max_generated_with_controller:.3f} | "
      "largest work of one tick = {most_work:.3f}");
  outcome.exit_code = failures > 0 ? exit_check_failed : exit_done;
  if (arguments.output.empty()) return std::nullopt;
  const auto path = [&](const char* name) {
    return (std::filesystem::path(arguments.output) / name).string();
  };
  if (Status error = data_tools::write_file_atomically(path("attacks.csv"), csv)) return error;
  if (Status error = data_tools::write_file_atomically(path("stiffness.csv"), map_csv)) return error;
  if (Status error =
          data_tools::write_file_atomically(path("stability.json"), text_of_json(outcome.json, 1) + "\n"))
    return error;
  if (Status error = view::write_chart_files(
          stiffness_chart(maps, "stable without a hand", "Stiffness that stays stable without a hand"),
          path("stable-stiffness")))
    return error;
  if (Status error = view::write_chart_files(
          stiffness_chart(maps, "passive for any hand", "Stiffness that is passive for any hand"),
          path("passive-stiffness")))
    return error;
  outcome.print("tables and maps: {folder}", {{"folder", arguments.output}});
  return std::nullopt;
}

}  // namespace trephine::bench
