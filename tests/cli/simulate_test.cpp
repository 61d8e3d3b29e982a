// simulate as a shell sees it: what it writes, refuses, and survives.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <thread>

#include "lib/report/csv.h"
#include "lib/report/report.h"
#include "tests/support/effort.h"
#include "tests/support/programs.h"
#include "tests/support/random_model.h"

namespace lanc::test {
namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

/// All complete rows can be read.
std::vector<Row> rows_of(const std::filesystem::path& csv) {
  std::vector<Row> rows;
  const std::vector<CsvRecord> records = read_csv(text_of(csv));
  for (std::size_t k = 1; k < records.size(); ++k) rows.push_back(csv_row(records[k].fields));
  return rows;
}

double value(const std::vector<Row>& rows, const std::string& t, const std::string& metric) {
  for (const Row& row : rows)
    if (row.cell.parameters.rfind("t=" + t + ";", 0) == 0 && row.measurement.metric == metric)
      return row.measurement.value;
  ADD_FAILURE() << "no " << metric << " at t = " << t;
  return NAN;
}

/// A run in the background, whose end can be brought about.
class Child {
 public:
  Child(const Words& arguments, rlim_t largest_file = RLIM_INFINITY) {
    const std::string program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "simulate";
    std::vector<const char*> argv = {program.c_str()};
    for (const std::string& word : arguments) argv.push_back(word.c_str());
    argv.push_back(nullptr);
    const std::string errors = folder() / "child.txt";
    pid_ = fork();
    if (pid_ != 0) return;
    const int file = ::open(errors.c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0666);
    ::dup2(file, STDOUT_FILENO), ::dup2(file, STDERR_FILENO);
    if (largest_file != RLIM_INFINITY) {
      const rlimit limit{largest_file, largest_file};
      ::setrlimit(RLIMIT_FSIZE, &limit);
    }
    ::execv(program.c_str(), const_cast<char* const*>(argv.data()));
    ::_exit(127);
  }
  void send(int signal) const { ::kill(pid_, signal); }
  /// Exit code, or 128 + the signal that ended it.
  int wait() const {
    int status = 0;
    ::waitpid(pid_, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

 private:
  pid_t pid_;
};

Words arguments(const std::string& integrator, const std::filesystem::path& out, bool resume = false) {
  Words words = {"four-bar-ladder:3:angle=2.6:rate=0.5",
                 "--integrator",
                 integrator,
                 "--step",
                 "1e-3",
                 "--tolerance",
                 "1e-9",
                 "--end",
                 "4",
                 "--interval",
                 "0.01",
                 "--checkpoint-every",
                 "10",
                 "--quiet",
                 "--out",
                 out};
  if (resume) words.push_back("--resume");
  return words;
}

/// The same rows as a run that nobody disturbed.
void expect_same(const std::filesystem::path& whole, const std::filesystem::path& other) {
  EXPECT_TRUE(text_of(whole) == text_of(other)) << whole << " and " << other << " differ";
}

TEST(Simulate, goes_on_after_being_killed_at_fifty_random_moments) {
  const std::filesystem::path whole = folder() / "whole.csv", killed = folder() / "killed.csv";
  for (const char* integrator : {"rk4"}) {
    const auto begin = Clock::now();
    ASSERT_EQ(run("simulate", arguments(integrator, whole)).exit_code, 0);
    const Seconds length = Clock::now() - begin;
    Random random(7);
    for (int kill = 0; kill < cases(50); ++kill) {
      const Child child(arguments(integrator, killed, kill > 0));
      std::this_thread::sleep_for(length * random.uniform(0, 0.3));
      child.send(SIGKILL);
      const int code = child.wait();
      EXPECT_TRUE(code == 128 + SIGKILL || code == 0) << code << " " << text_of(folder() / "child.txt");
      if (std::filesystem::exists(killed)) (void)rows_of(killed);
    }
    const Finished last = run("simulate", arguments(integrator, killed, true));
    EXPECT_EQ(last.exit_code, 0) << last.error;
    expect_same(whole, killed);
  }
}

TEST(Simulate, goes_on_after_an_interrupt) {
  for (const char* integrator : {"rk4", "generalized-alpha", "erk5"}) {
    // files of its own: a run that is interrupted before it has opened its file must not find another one's
    const std::filesystem::path whole = folder() / "whole.csv", cut = folder() / (std::string(integrator) + "-cut.csv");
    const auto begin = Clock::now();
    const Finished first = run("simulate", arguments(integrator, whole));
    if (first.error.find("there is no integrator") != std::string::npos) continue;  // built without SUNDIALS
    ASSERT_EQ(first.exit_code, 0) << first.error;
    const Seconds length = Clock::now() - begin;
    const Child child(arguments(integrator, cut));
    std::this_thread::sleep_for(length * 0.6);
    child.send(SIGINT);
    const int code = child.wait();
    EXPECT_TRUE(code == 130 || code == 0) << code;
    if (std::filesystem::exists(cut)) (void)rows_of(cut);
    const Finished last = run("simulate", arguments(integrator, cut, true));
    EXPECT_EQ(last.exit_code, 0) << last.error;
    expect_same(whole, cut);
  }
}

TEST(Simulate, goes_on_after_the_file_could_not_grow) {
  const std::filesystem::path whole = folder() / "whole.csv", cut = folder() / "limited.csv";
  ASSERT_EQ(run("simulate", arguments("rk4", whole)).exit_code, 0);
  const auto size = std::filesystem::file_size(whole);
  const Child child(arguments("rk4", cut), size / 2);
  EXPECT_EQ(child.wait(), 2);
  EXPECT_NE(text_of(folder() / "child.txt").find("cannot write"), std::string::npos) << text_of(folder() / "child.txt");
  EXPECT_GT(rows_of(cut).size(), 100u);
  EXPECT_EQ(run("simulate", arguments("rk4", cut, true)).exit_code, 0);
  expect_same(whole, cut);
}

TEST(Simulate, writes_the_path_of_a_point_and_stops_where_it_is_told_to) {
  const std::filesystem::path out = folder() / "pendulum.csv";
  const Finished r = run("simulate", {LANC_SOURCE_DIR "/data/models/problems/a01.toml", "--integrator", "rk4",
                                      "--point", "P=bar:-1,0,0", "--end", "3", "--interval", "0.5", "--step", "1e-3",
                                      "--out", out, "--quiet", "--stop-when", "P.x>0"});
  ASSERT_EQ(r.exit_code, 0) << r.error;
  EXPECT_NE(r.out.find("P.x>0"), std::string::npos) << r.out;
  const std::vector<Row> rows = rows_of(out);
  EXPECT_NEAR(value(rows, "0.5", "P.x"), -0.391049, 5e-7);  // IFToMM problem A01
  // a quarter of the period is at the lowest point
  const double t = std::stod(rows.back().cell.parameters.substr(2));
  EXPECT_NEAR(t, 2.367841947576237 / 4, 1e-9);
}

TEST(Simulate, stops_at_the_first_condition_that_is_met_and_at_once_where_one_is_met_at_the_start) {
  const std::filesystem::path out = folder() / "stops.csv";
  const Words turning = {"chain:1:gravity=0", "--q", "0", "--v", "1", "--integrator", "rk4", "--quiet", "--out", out};
  const auto stopped = [&](const Words& conditions) {
    Words all = turning;
    for (const std::string& condition : conditions) all.insert(all.end(), {"--stop-when", condition});
    const Finished r = run("simulate", all);
    EXPECT_EQ(r.exit_code, 0) << r.error;
    return std::stod(rows_of(out).back().cell.parameters.substr(2));
  };
  EXPECT_NEAR(stopped({"q.j1.angle>2.005", "q.j1.angle>2.002"}), 2.002, 1e-9);
  EXPECT_EQ(stopped({"q.j1.angle>-1"}), 0);
}

TEST(Simulate, resumes_nothing_but_its_own_run) {
  const std::filesystem::path out = folder() / "own.csv";
  ASSERT_EQ(run("simulate", arguments("rk4", out)).exit_code, 0);
  Words other = arguments("rk4", out, true);
  other.insert(other.end(), {"--wrench", "u0=0,0,0,1,0,0"});
  const Finished refused = run("simulate", other);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.error.find("wrenches"), std::string::npos) << refused.error;
  std::filesystem::resize_file(out, 5000);  // a checkpoint that is ahead of its CSV
  EXPECT_EQ(run("simulate", arguments("rk4", out, true)).exit_code, 2);
}

TEST(Simulate, writes_over_no_input) {
  const std::string text = text_of(LANC_SOURCE_DIR "/data/models/problems/a01.toml");
  const std::string model = write("own-model.csv.toml", text), state = write("kept.state.json", R"({"v": [1]})");
  const Finished r = run("simulate", {model, "--quiet", "--out", model});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.error.find("this is an input"), std::string::npos) << r.error;
  EXPECT_EQ(text_of(model), text);
  // a state that a run left is no file for the next one to take away
  EXPECT_EQ(run("simulate", {model, "--quiet", "--state", state, "--out", folder() / "kept.csv"}).exit_code, 2);
  EXPECT_TRUE(std::filesystem::exists(state));
}

TEST(Simulate, follows_a_hundred_thousand_bodies) {
  const Finished r = run("simulate", {"chain:100000", "--integrator", "rk4", "--step", "1e-6", "--interval", "1e-6",
                                      "--end", "1e-6", "--quiet", "--out", folder() / "large.csv"});
  EXPECT_EQ(r.exit_code, 0) << r.error;
}

TEST(Simulate, refuses_what_it_cannot_do) {
  struct Case {
    Words words;
    const char* message;
  };
  const std::string out = folder() / "refused.csv";
  for (const auto& [words, message] : std::vector<Case>{
           {{"chain:2", "--end", "-1"}, "is not after the start"},
           {{"chain:2", "--integrator", "leapfrog"}, "there is no integrator 'leapfrog'; choose from"},
           {{"four-bar-ladder:1:angle=2.6:rate=0.5", "--stabilisation", "glue"}, "there is no stabilisation 'glue'"},
           {{"chain:2", "--point", "P=b9:0,0,0"}, "there is no body 'b9'"},
           {{"chain:2", "--point", "P=b1:0,0"}, "three numbers are needed"},
           {{"chain:2", "--stop-when", "q.j1=2"}, "'QUANTITY<VALUE'"},
           {{"chain:2", "--stop-when", "q.j7>2"}, "there is no quantity 'q.j7'"},
           {{"four-bar-ladder:1:angle=2.6", "--integrator", "generalized-alpha", "--stabilisation", "baumgarte"},
            "holds the closure conditions itself"},
           {{"chain:2", "--stabilisation", "glue"}, "there is no stabilisation 'glue'"},
           {{"chain:2", "--stop-when", "q.j1.angle>nan"}, "one finite number"},
           {{"chain:2", "--point", "P=b1:0,0,0", "--point", "P=b2:0,0,0"}, "two points are called 'P'"},
           {{"chain:2", "--singular", "jump"}, "choose stop, pass, or branch:1"},
           {{"four-bar-ladder:1:angle=2.6:rate=0.5", "--stabilisation", "minimal", "--independent", "nobody"},
            "there is no velocity 'nobody'"}}) {
    Words all = words;
    all.insert(all.end(), {"--quiet", "--out", out});
    const Finished r = run("simulate", all);
    EXPECT_EQ(r.exit_code, 2) << message << "\n" << r.out;
    EXPECT_NE(r.error.find(message), std::string::npos) << "expected: " << message << "\ngot: " << r.error;
  }
}

TEST(Simulate, ends_with_the_reason_and_the_state_where_a_status_ends_the_run) {
  const std::filesystem::path out = folder() / "open.csv";
  const Finished r =
      run("simulate", {"four-bar-ladder:1:angle=2.6:rate=0.5", "--q", "0.4,0.1,0.2", "--out", out, "--quiet"});
  EXPECT_EQ(r.exit_code, 1);
  EXPECT_NE(r.out.find("inconsistent"), std::string::npos) << r.out;
  EXPECT_TRUE(std::filesystem::exists(folder() / "open.state.json"));
}

TEST(Linearise, tells_frequencies_as_text_and_json) {
  const Words model = {LANC_SOURCE_DIR "/data/models/problems/four-bar-spring.toml", "--equilibrium", "stable"};
  Words json = model;
  json.insert(json.end(), {"--format", "json", "--independent", "D.angle_rate"});
  const Finished told = run("linearise", json);
  ASSERT_EQ(told.exit_code, 0) << told.error;
  EXPECT_NEAR(told.json()["K"][0][0].get<double>(), 7.687524905947406, 1e-9);
  EXPECT_NEAR(told.json()["eigenvalues"][1][1].get<double>(), 2.1339550283484, 1e-10);
  const Finished text = run("linearise", model);
  EXPECT_NE(text.out.find("Eigenvalues"), std::string::npos) << text.out;
  EXPECT_EQ(run("linearise", {"chain:2", "--equilibrium", "perhaps"}).exit_code, 2);
}

}  // namespace
}  // namespace lanc::test
