// What solve, inverse and inspect say to bad input, and to --help and the lists.
#include <gtest/gtest.h>

#include "tests/support/programs.h"

namespace {

using lanc::test::folder, lanc::test::run, lanc::test::write, lanc::test::Finished, lanc::test::Words;

}  // namespace

TEST(CommandLine, HelpAndListsEndWellWithoutAModel) {
  for (const char* program : {"solve", "inverse", "inspect"}) {
    const Finished help = run(program, {"--help"});
    EXPECT_EQ(help.exit_code, 0);
    EXPECT_NE(help.out.find("--state"), std::string::npos);
    EXPECT_NE(run(program, {"--list-models"}).out.find("chain:N"), std::string::npos);
    const Finished list = run(program, {"--list-formulations"});
    EXPECT_EQ(list.exit_code, 0);
    EXPECT_NE(list.out.find("recursive"), std::string::npos);
  }
}

TEST(CommandLine, BadInputExitsWithTwoAndSaysWhatToMend) {
  struct Case {
    Words arguments;
    const char* message;
  };
  const std::string bad_json = write("bad.json", "{\"q\": [0.1,\n}"), odd_json = write("odd.json", "{\"x\": 1}"),
                    list_json = write("list.json", "[1]"), word_json = write("word.json", "{\"q\": \"a\"}"),
                    twice_json = write("twice.json", R"({"q": [0, 0], "q": [1, 1]})"),
                    twice_body_json =
                        write("twice_body.json", R"({"wrenches": {"b1": [0,0,0,0,0,0], "b1": [1,0,0,0,0,0]}})"),
                    bad_toml = write("bad.toml", "[[body]]\nname = \"b\"\nmass = 1\ncolour = 1\n");
  const std::vector<Case> cases = {
      {{}, "MODEL is required"},
      {{"nosuch"}, "'nosuch' is neither a model file (*.toml, *.urdf) nor a generator"},
      {{"nosuch.toml"}, "nosuch.toml"},
      {{"chain:0"}, "0 bodies; give a number from 1 to"},
      {{bad_toml}, "bad.toml:4:"},
      {{"chain:2", "--q", "1"}, "q has 1 numbers, the model needs 2: j1.angle, j2.angle"},
      {{"chain:2", "--q", ""}, "q has 0 numbers"},
      {{"chain:2", "--v", "1,two"}, "--v: 'two' is not a number"},
      {{"chain:2", "--v", "1,nan"}, "v: j2.angle_rate is not a finite number"},
      {{"chain:2", "--q", "1,,2"}, "--q: a number is missing before a comma in '1,,2'"},
      {{"chain:2", "--q", ",1,2"}, "--q: a number is missing before a comma"},
      {{"chain:2", "--q", "1,2,"}, "--q: a number is missing after the last comma of '1,2,'"},
      {{"chain:2", "--v", "1", ",", ",", "2"}, "--v: a number is missing before a comma in '1 , , 2'"},
      {{"chain:2", "--v", "1,+-2"}, "--v: '+-2' is not a number"},
      {{"chain:2", "--time", "inf"}, "the time is not a finite number"},
      {{"chain:2", "--tau", "1,2,3"}, "tau has 3 numbers, the model needs 2"},
      {{"chain:2", "--tau", "1,1e999"}, "'1e999' is not a number"},
      {{"chain:2", "--wrench", "b2"}, "not of the form BODY="},
      {{"chain:2", "--wrench", "b9=0,0,0,0,0,0"}, "there is no body 'b9'"},
      {{"chain:2", "--wrench", "b2=1,2"}, "2 numbers for body 'b2', a wrench has six"},
      {{"chain:1:joint=spherical", "--q", "1,1,0,0"}, "have length 1.414"},
      {{"chain:2", "--formulation", "magic"}, "there is no formulation 'magic'; choose from"},
      {{"chain:2", "--format", "xml"}, "--format"},
      {{"chain:2", "--colour"}, "--colour"},
      {{"chain:2", "chain:3"}, "chain:3"},
      {{"chain:2", "--state", "nosuch.json"}, "nosuch.json: this file cannot be read"},
      {{"chain:2", "--state", bad_json}, "line 2"},
      {{"chain:2", "--state", odd_json}, "unknown key 'x'"},
      {{"chain:2", "--state", list_json}, "not a JSON object"},
      {{"chain:2", "--state", word_json}, "arrays of numbers, are expected"},
      {{"chain:2", "--state", twice_json}, "twice.json: the key 'q' is there twice; remove one"},
      {{"chain:2", "--state", twice_body_json}, "twice_body.json: the key 'b1' is there twice"},
      {{"chain:2", "--state", "."}, ".: this is a directory; name a JSON file in it"},
      {{"chain:2", "--state", ""}, "--state: nothing is given"},
      {{"chain:2", "--export", ""}, "--export: nothing is given"},
      {{"chain:2", "--formulation", ""}, "--formulation: nothing is given"},
      {{"chain:2", "--out", ""}, "--out: nothing is given"},
      {{"chain:2", "--out", "/nosuch/folder/file"}, "cannot be written"},
      {{"chain:2", "--export", "/proc/nosuch"}, "cannot be made"},
      {{"chain:4000", "--export", folder().string()}, "at most 3000"},
  };
  for (const auto& [arguments, message] : cases) {
    const Finished r = run("solve", arguments);
    EXPECT_EQ(r.exit_code, 2) << message;
    EXPECT_EQ(r.out, "") << message;
    EXPECT_NE(r.error.find(message), std::string::npos) << "expected: " << message << "\ngot: " << r.error;
  }
  EXPECT_EQ(run("inverse", {"chain:2", "--vdot", "1"}).exit_code, 2);
  EXPECT_EQ(run("inverse", {"chain:2", "--vdot", "1,inf"}).exit_code, 2);
  EXPECT_EQ(run("inspect", {"chain:2", "--tau", "1,2"}).exit_code, 2);
}
