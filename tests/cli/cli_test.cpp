// The programs solve, inverse and inspect as a shell sees them: arguments in, JSON, text and exit codes out.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "lib/formulation/formulation.h"
#include "lib/solve/ipopt.h"
#include "tests/support/programs.h"

namespace {

using lanc::test::folder, lanc::test::run, lanc::test::text_of, lanc::test::write, lanc::test::Finished,
    lanc::test::Words;
namespace fs = std::filesystem;
using Json = nlohmann::json;

Words keys(const Json& object) {
  Words names;
  for (const auto& [key, value] : object.items()) names.push_back(key);
  return names;
}

Words sorted(Words words) {
  std::sort(words.begin(), words.end());
  return words;
}

/// A dense matrix of a Matrix Market file.
Eigen::MatrixXd read_matrix(const fs::path& path) {
  std::ifstream file(path);
  std::string banner, line;
  std::getline(file, banner);
  while (file.peek() == '%') std::getline(file, line);
  Eigen::Index rows = 0, columns = 0;
  file >> rows >> columns;
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(rows, columns);
  if (banner.find("array") != banner.npos) {
    for (Eigen::Index k = 0; k < matrix.size(); ++k) file >> matrix.data()[k];
  } else {
    std::int64_t entries = 0;
    file >> entries;
    for (std::int64_t k = 0; k < entries; ++k) {
      Eigen::Index r = 0, c = 0;
      file >> r >> c;
      file >> matrix(r - 1, c - 1);
      if (banner.find("symmetric") != banner.npos) matrix(c - 1, r - 1) = matrix(r - 1, c - 1);
    }
  }
  EXPECT_FALSE(file.fail()) << path;
  return matrix;
}

Eigen::VectorXd vector_of(const Json& list) {
  const auto values = list.get<std::vector<double>>();
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

}  // namespace

TEST(Solve, JsonHasTheKeysOfTheContract) {
  const Finished r = run("solve", {"random:8:seed=3", "--format", "json"});
  ASSERT_EQ(r.exit_code, 0) << r.error;
  EXPECT_EQ(r.error, "");
  const Json j = r.json();
  EXPECT_EQ(keys(j), sorted({"status", "message", "names", "vdot", "acceleration", "wrench", "lambda", "drive_force",
                             "rank", "redundant", "sigma", "residual", "condition", "flops", "seconds"}));
  EXPECT_EQ(j["status"], "solved");
  EXPECT_EQ(j["names"]["bodies"].size(), 8u);
  EXPECT_EQ(j["names"]["velocities"].size(), j["vdot"].size());
  EXPECT_EQ(j["names"]["drives"].size(), j["drive_force"].size());
  EXPECT_EQ(j["acceleration"].size(), 8u);
  EXPECT_EQ(j["wrench"][7].size(), 6u);
  EXPECT_EQ(j["lambda"], Json::array());
  EXPECT_LT(j["residual"].get<double>(), 1e-11);
  EXPECT_GE(j["condition"].get<double>(), 1);
  for (const char* phase : {"kinematics", "assemble", "factorise", "solve", "total"}) {
    EXPECT_TRUE(j["flops"][phase].is_number_integer()) << phase;
    EXPECT_TRUE(j["seconds"][phase].is_number()) << phase;
  }
  EXPECT_TRUE(j["seconds"]["analyse"].is_number());
}

TEST(Solve, PendulumFallsAsBooksSay) {
  const std::string model = write("pendulum.toml", R"(gravity = [0, 0, -9.81]
[[body]]
name = "bob"
mass = 2
com = [0, 0, -0.5]
[[joint]]
name = "hinge"
type = "revolute"
body = "bob"
axis = [0, 1, 0]
)");
  const Finished r = run("solve", {model, "--q", "0.3", "--v=-2", "--tau", "0.25", "--format", "json"});
  ASSERT_EQ(r.exit_code, 0) << r.error;
  const double expected = (0.25 - 2 * 9.81 * 0.5 * std::sin(0.3)) / (2 * 0.25);
  EXPECT_NEAR(r.json()["vdot"][0].get<double>(), expected, 1e-13);
}

TEST(Solve, StateFileAndOptionsAgreeAndOptionsWin) {
  const std::string file = write("state.json", R"({"t": 0.5, "q": [0.1, 0.2], "v": [1, -1], "tau": [0, 3],
                              "wrenches": {"b2": [0, 0, 1, 2, 0, 0]}})");
  const Json by_file = run("solve", {"chain:2", "--state", file, "--format", "json"}).json();
  const Json by_options = run("solve", {"chain:2", "--time", "0.5", "--q", "0.1,0.2", "--v", "1", "-1", "--tau", "0, 3",
                                        "--wrench", "b2=0,0,1,2,0,0", "--format", "json"})
                              .json();
  EXPECT_EQ(by_file["vdot"], by_options["vdot"]);
  EXPECT_EQ(by_file["wrench"], by_options["wrench"]);
  const Json other = run("solve", {"chain:2", "--state", file, "--q", "0.3,0.2", "--format", "json"}).json();
  EXPECT_NE(by_file["vdot"], other["vdot"]);
}

TEST(Solve, OptionsMayComeBeforeTheModel) {
  const Finished r = run("solve", {"--q", "0.1", "-0.2", "--format", "json", "chain:2"});
  ASSERT_EQ(r.exit_code, 0) << r.error;
  EXPECT_EQ(r.json()["vdot"], run("solve", {"chain:2", "--q", "0.1,-0.2", "--format", "json"}).json()["vdot"]);
}

TEST(Solve, NegativeNumbersMayStandAsWordsOfTheirOwn) {
  const Json by_one_word = run("solve", {"chain:3", "--q=-.5,-0.25,-1e-3", "--v=-.5,-2,-0.5", "--time=-.5",
                                         "--tau=-.5,0,-3", "--format", "json"})
                               .json();
  for (const Words& options :
       {Words{"--q", "-.5", "-.25", "-1e-3", "--v", "-.5,-2", "-.5", "--time", "-.5", "--tau", "-.5", "0", "-3"},
        Words{"--q", "-.5,-.25", "-.1e-2", "--v", "-.5", "-2,-.5", "--time", "-.5", "--tau", "-.5,-.0", "-3"}}) {
    Words arguments = {"chain:3", "--format", "json"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const Finished r = run("solve", arguments);
    ASSERT_EQ(r.exit_code, 0) << r.error;
    EXPECT_EQ(r.json()["vdot"], by_one_word["vdot"]);
  }
  EXPECT_EQ(run("solve", {"chain:1", "--wrench", "b1=-.5,-1e-3,-1,-.2,-3,0"}).exit_code, 0);
  EXPECT_EQ(run("inverse", {"chain:2", "--vdot", "-.5", "-1e-3"}).exit_code, 0);
}

TEST(Solve, EveryFormulationAnswersOrSaysWhyNot) {
  for (const char* model : {"chain:4", "random:12:seed=5", "random:12:seed=6:massless=no"}) {
    const Finished all = run("solve", {model, "--formulation", "all", "--format", "json"});
    EXPECT_EQ(all.exit_code, 0) << all.out;
    const Json answers = all.json();
    EXPECT_EQ(answers.size(), lanc::formulations().size());
    const Eigen::VectorXd reference = vector_of(answers["recursive"]["vdot"]);
    for (const auto& [name, answer] : answers.items()) {
      if (answer["status"] == "objection") {
        EXPECT_NE(answer["message"], "") << name;
        EXPECT_TRUE(answer["vdot"].is_null() && answer["residual"].is_null()) << name;
        EXPECT_EQ(run("solve", {model, "--formulation", name}).exit_code, 1) << name;
      } else {
        EXPECT_LT((vector_of(answer["vdot"]) - reference).norm(), 1e-9 * reference.norm()) << model << " " << name;
      }
    }
    const Finished table = run("solve", {model, "--formulation", "*"});
    for (const auto& [name, answer] : answers.items()) EXPECT_NE(table.out.find(name), std::string::npos);
  }
}

TEST(Solve, SingularMechanismsExitWithOneAndSayWhichBody) {
  const std::string model = write("massless.toml", R"([[body]]
name = "ghost"
mass = 0
[[joint]]
name = "hinge"
type = "revolute"
body = "ghost"
)");
  const Finished json = run("solve", {model, "--format", "json"});
  EXPECT_EQ(json.exit_code, 1);
  EXPECT_EQ(json.json()["status"], "singular");
  EXPECT_TRUE(json.json()["vdot"].is_null());
  EXPECT_TRUE(json.json()["condition"].is_null());
  const Finished text = run("solve", {model});
  EXPECT_EQ(text.exit_code, 1);
  EXPECT_NE(text.out.find("singular"), std::string::npos);
  EXPECT_NE(run("inspect", {model}).out.find("no solution"), std::string::npos);
}

TEST(Solve, MotionsThatAreNotDefinedAreNotFinite) {
  const std::string model = write("spline.toml", R"([[body]]
name = "arm"
mass = 1
inertia = [1, 1, 1]
[[joint]]
name = "hinge"
type = "revolute"
body = "arm"
motion = { type = "spline", times = [0, 1, 2, 2.5], values = [0, 1, 0, 1] }
)");
  EXPECT_EQ(run("solve", {model, "--time", "1.5"}).exit_code, 0);
  const Finished outside = run("solve", {model, "--time", "3", "--format", "json"});
  EXPECT_EQ(outside.exit_code, 1);
  EXPECT_EQ(outside.json()["status"], "not_finite");
  EXPECT_TRUE(outside.json()["drive_force"].is_null());
  const Json inverse = run("inverse", {model, "--time", "3", "--format", "json"}).json();
  EXPECT_EQ(inverse["status"], "not_finite");
  for (const Json& told : {outside.json()["message"], inverse["message"]})
    EXPECT_NE(told.get<std::string>().find("prescribed motion of joint 'hinge'"), std::string::npos) << told;
}

TEST(Solve, ExportedMatricesGiveTheSameAnswer) {
  const fs::path target = folder() / "matrices" / "new";
  const Finished r = run("solve", {"random:7:seed=12", "--export", target.string(), "--format", "json"});
  ASSERT_EQ(r.exit_code, 0) << r.error;
  const Eigen::VectorXd vdot = vector_of(r.json()["vdot"]);
  const Eigen::MatrixXd A = read_matrix(target / "eq14.mtx"), M = read_matrix(target / "mass_matrix.mtx");
  const Eigen::MatrixXd b = read_matrix(target / "eq14_rhs.mtx");
  const Eigen::VectorXd x = A.fullPivLu().solve(b.col(0));
  ASSERT_EQ(M.rows(), vdot.size());
  EXPECT_EQ(read_matrix(target / "closure_jacobian.mtx").cols(), vdot.size());

  std::istringstream rows(text_of(target / "eq14_rows.csv"));
  std::string line;
  std::getline(rows, line);
  EXPECT_EQ(line, "row,unknown,of,equation");
  std::vector<int> velocity_rows;
  for (int row = 0; std::getline(rows, line); ++row)
    if (line.find(",vdot,") != line.npos) velocity_rows.push_back(row);
  ASSERT_EQ(static_cast<Eigen::Index>(velocity_rows.size()), vdot.size());
  for (Eigen::Index k = 0; k < vdot.size(); ++k)
    EXPECT_NEAR(x[velocity_rows[static_cast<std::size_t>(k)]], vdot[k], 1e-9 * vdot.norm());

  // M̄ is what is left of eq. 14 when â and f̂ are eliminated
  std::vector<int> others;
  for (int row = 0; row < A.rows(); ++row)
    if (!std::count(velocity_rows.begin(), velocity_rows.end(), row)) others.push_back(row);
  const Eigen::MatrixXd schur =
      A(velocity_rows, velocity_rows) -
      A(velocity_rows, others) * A(others, others).fullPivLu().solve(A(others, velocity_rows));
  EXPECT_LT((schur - M).norm(), 1e-11 * M.norm());
  EXPECT_NE(text_of(target / "README.md").find("mass_matrix.mtx"), std::string::npos);
}

TEST(Solve, AssemblesTheStateWhenItIsAskedTo) {
  const std::string model = LANC_SOURCE_DIR "/data/models/closure-distance.toml";
  const Words later = {model, "--time", "1", "--format", "json"};
  EXPECT_EQ(run("solve", later).exit_code, 1);  // the boom is not where its cylinder wants it
  Words assembled = later;
  assembled.push_back("--assemble");
  const Finished r = run("solve", assembled);
  ASSERT_EQ(r.exit_code, 0) << r.error;
  EXPECT_NE(r.error.find("largest change of a position 0.488 rad"), std::string::npos) << r.error;
  const double s = std::sqrt(2.0) + 0.3, sine = s * s / 2 - 1, cosine = std::sqrt(1 - sine * sine);
  const double rate = 0.3 * s / cosine;  // derivatives of s² = 2 + 2 sin q
  EXPECT_NEAR(r.json()["vdot"][0].get<double>(), (0.09 + sine * rate * rate) / cosine, 1e-12);
  const Finished never = run("solve", {model, "--time", "20", "--assemble"});
  EXPECT_EQ(never.exit_code, 2);
  EXPECT_NE(never.error.find("'cylinder.length' open by 5.41 m"), std::string::npos) << never.error;
  EXPECT_NE(never.error.find("cannot be assembled"), std::string::npos) << never.error;
}

TEST(Solve, KeepsJointsWithinTheirLimitsWhenItIsAskedTo) {
  std::string text = text_of(fs::path(LANC_SOURCE_DIR) / "data/models/linkages/planar-four-bar.toml");
  const std::string hinge = "body = \"link1\"\n";
  text.insert(text.find(hinge) + hinge.size(), "limits = [0.2, 0.7]\n");
  const std::string model = write("limited.toml", text);
  const Finished nearest = run("solve", {model, "--assemble"});
  EXPECT_EQ(nearest.exit_code, 0) << nearest.error;
  EXPECT_NE(nearest.error.find("'hinge1.angle' 0.2 rad beyond its lower limit 0.2 rad"), std::string::npos)
      << nearest.error;
  const Finished limited = run("solve", {model, "--within-limits"});
  if (lanc::has_ipopt()) {
    EXPECT_EQ(limited.exit_code, 0) << limited.error;
    EXPECT_NE(limited.error.find("'hinge1.angle' at its lower limit 0.2 rad"), std::string::npos) << limited.error;
  } else {
    EXPECT_EQ(limited.exit_code, 2);
    EXPECT_NE(limited.error.find("LANC_WITH_IPOPT"), std::string::npos) << limited.error;
  }
}

TEST(Solve, OutWritesToAFile) {
  const std::string file = (folder() / "answer.json").string();
  const Finished r = run("solve", {"chain:2", "--format", "json", "--out", file});
  EXPECT_EQ(r.exit_code, 0);
  EXPECT_EQ(r.out, "");
  EXPECT_EQ(Json::parse(text_of(file))["status"], "solved");
}

TEST(Solve, DoesNotWriteOverItsInputs) {
  const std::string model = write("kept.toml", text_of(fs::path(LANC_SOURCE_DIR) / "data/models/joint-revolute.toml"));
  const Finished run_over = run("solve", {model, "--out", model});
  EXPECT_EQ(run_over.exit_code, 2);
  EXPECT_NE(run_over.error.find("choose another --out"), std::string::npos) << run_over.error;
  EXPECT_EQ(text_of(model), text_of(fs::path(LANC_SOURCE_DIR) / "data/models/joint-revolute.toml"));
}

TEST(Inverse, ReturnsTheForcesThatSolveWasGiven) {
  const Json forward = run("solve", {"random:6:seed=21", "--format", "json", "--formulation", "dense"}).json();
  std::ostringstream vdot;
  vdot.precision(17);
  for (const double x : forward["vdot"]) vdot << x << ' ';
  const Finished r = run("inverse", {"random:6:seed=21", "--vdot", vdot.str(), "--format", "json"});
  ASSERT_EQ(r.exit_code, 0) << r.error;
  const Json j = r.json();
  EXPECT_EQ(keys(j), sorted({"status", "message", "names", "vdot", "tau", "acceleration", "wrench", "lambda",
                             "drive_force", "residual"}));
  for (const double tau : j["tau"]) EXPECT_NEAR(tau, 0, 1e-10);
  EXPECT_LT((vector_of(j["drive_force"]) - vector_of(forward["drive_force"])).norm(), 1e-9);
}

TEST(Inverse, HoldsAPendulumWhenNoAccelerationIsGiven) {
  const Json j = run("inverse", {"chain:1", "--q", "0", "--v", "0", "--format", "json"}).json();
  EXPECT_NEAR(j["tau"][0].get<double>(), -9.81 * 0.02, 1e-14);  // about x; the mass is at y = -0.02
}

TEST(Inspect, JsonHasTheKeysOfTheContract) {
  const Finished r = run("inspect", {"tree:5:joint=spherical", "--format", "json"});
  ASSERT_EQ(r.exit_code, 0) << r.error;
  const Json j = r.json();
  EXPECT_EQ(keys(j), sorted({"bodies", "joints", "loops", "cuts", "reversed", "velocities", "closure_rows", "grubler",
                             "rank", "generic_rank", "redundant", "mobility", "finite_mobility", "verdict", "sigma",
                             "redundant_rows", "removable_rows", "unique_reactions"}));
  EXPECT_EQ(j["bodies"].size(), 5u);
  EXPECT_EQ(j["joints"][4]["parent"], "b2");
  EXPECT_EQ(j["mobility"], 15);
  EXPECT_EQ(j["verdict"], "regular");
  EXPECT_EQ(j["loops"], Json::array());
}

TEST(Inspect, TextShowsWhatAnEngineerAsksFor) {
  const Finished r = run("inspect", {std::string(LANC_SOURCE_DIR) + "/data/models/springs.toml"});
  ASSERT_EQ(r.exit_code, 0) << r.error;
  for (const char* text :
       {"finite mobility", "left_rail", "prismatic", "Point springs", "tie", "friction", "point mass"})
    EXPECT_NE(r.out.find(text), std::string::npos) << text << " is missing in\n" << r.out;
}
