// export: tables of a session, read by h5py and compared with the table of `replay`.
#include "tests/apps/command_fixture.h"

namespace trephine::command_tests {
namespace {

/// Python program that compares every tick of the exported tables (first argument) with its row of steps.csv
/// (second argument), exactly. It prints the number of rows, the removed volume, the numbers of commands and
/// events, and the names of the instruments.
constexpr const char* k_compare = R"(
import csv, sys, h5py
f = h5py.File(sys.argv[1])
rows = list(csv.DictReader(open(sys.argv[2])))
assert f.attrs['schema'] == 'trephine.session/1' and f.attrs['rate'] == 1000, dict(f.attrs)
for h in f['hands']:
    hand = {name: f['hands'][h][name][:] for name in f['hands'][h]}
    own = [r for r in rows if r['hand'] == h]
    assert len(own) == len(hand['tick']) > 0, (h, len(own), len(hand['tick']))
    for i, r in enumerate(own):
        for column, prefix in (('position', 'hip'), ('proxy', 'proxy'), ('force', 'force'), ('torque', 'torque')):
            for a, axis in enumerate('xyz'):
                assert float(r[prefix + '_' + axis]) == hand[column][i][a], (h, i, column)
        assert [float(r[q]) for q in ('qw', 'qx', 'qy', 'qz')] == list(hand['rotation'][i]), (h, i)
        assert int(r['contact']) == hand['contact'][i] and float(r['t']) == hand['time'][i], (h, i)
        assert hand['shape'][i] < len(f['shapes/name']), i
print(len(rows), f['removed/volume'][-1], len(f['commands/name']), len(f['events/name']),
      ','.join(n.decode() for n in f['instruments/name']))
)";

TEST_F(Command, ExportedTablesEqualTheReplay) {
  if (std::system("/usr/bin/python3 -c 'import h5py' 2>/dev/null") != 0) GTEST_SKIP() << "no python3-h5py";
  ASSERT_EQ(run("phantom sphere --size 48 --psf 1 -o s.mha").exit_code, 0);
  write_press("p.csv", 2);
  const Json drill = json("drill s.mha --burr-diameter 4 --path p.csv -o d.mha --record d.session");
  json("replay d.session --scan s.mha --table steps.csv");
  const Json tables = json("export d.session --scan s.mha -o d.h5");
  EXPECT_EQ(tables["ticks"], drill["steps"]);
  write("compare.py", k_compare);
  const auto compare = [&] {
    return std::system(("/usr/bin/python3 '" + file("compare.py") + "' '" + file("d.h5") + "' '" +
                        file("steps.csv") + "' > '" + file("facts") + "' 2>&1")
                           .c_str());
  };
  ASSERT_EQ(compare(), 0) << read(file("facts"));
  std::istringstream facts(read(file("facts")));
  std::size_t rows = 0, commands = 0, events = 0;
  double removed = 0;
  std::string instruments;
  facts >> rows >> removed >> commands >> events >> instruments;
  EXPECT_EQ(rows, drill["steps"].get<std::size_t>());
  EXPECT_DOUBLE_EQ(removed, drill["removed_mm3_total"].get<double>());
  EXPECT_EQ(commands, tables["commands"].get<std::size_t>());
  EXPECT_EQ(events, tables["events"].get<std::size_t>());
  EXPECT_EQ(instruments, "burr");
  EXPECT_EQ(read(file("d.h5")).find("s.mha"), std::string::npos);

  // Planted fault: one digit of steps.csv is changed, which the comparison detects.
  std::string steps = read(file("steps.csv"));
  const std::size_t digit = steps.find_first_of("123456789", steps.size() / 2);
  steps[digit] = steps[digit] == '9' ? '8' : static_cast<char>(steps[digit] + 1);
  write("steps.csv", steps);
  EXPECT_NE(compare(), 0);

  // Equal sessions give equal bytes; the example in the documentation runs.
  json("export d.session --scan s.mha -o again.h5");
  EXPECT_EQ(read(file("again.h5")), read(file("d.h5")));
  EXPECT_EQ(
      std::system((std::string("/usr/bin/python3 '") + TREPHINE_SOURCE_DIR +
                   "/docs/examples/read_session.py' '" + file("d.h5") + "' > '" + file("facts") + "' 2>&1")
                      .c_str()),
      0)
      << read(file("facts"));
  EXPECT_NE(read(file("facts")).find("hand 1: "), std::string::npos);

  for (const auto& [arguments, words] : std::initializer_list<std::pair<std::string, std::string>>{
           {"d.session --scan s.mha -o d.txt", ".h5"},
           {"d.session --scan s.mha -o d.session", "d.session"},
           {"d.session -o e.h5", "--scan"}}) {
    const ProcessResult bad = run("export " + arguments);
    EXPECT_EQ(bad.exit_code, 2) << arguments;
    EXPECT_NE(bad.err.find(words), std::string::npos) << arguments << "\n" << bad.err;
  }
}

}  // namespace
}  // namespace trephine::command_tests
