// The CSV survives quoting, interruption and continuation; the sidecar says how it was made.
#include "lib/report/report.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>

#include "lib/model/error.h"
#include "lib/report/csv.h"
#include "lib/report/sidecar.h"

namespace lanc {
namespace {

const std::vector<std::string> command_line = {"program", "--quick"};

std::string contents(const std::string& name) {
  std::ifstream in(name, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

Cell cell(const std::string& model, int repetition = 0) {
  Cell c;
  c.model = model;
  c.bodies = 3;
  c.velocities = 4;
  c.formulation = "some";
  c.seed = 1;
  c.repetition = repetition;
  return c;
}

const std::vector<Measurement> two_rows = {{"solve", "time", 1.5e-6, "s"}, {"total", "time", 2.5e-6, "s"}};

class ReportFile : public ::testing::Test {
 protected:
  ReportFile() {
    std::filesystem::create_directories(folder_);
    file = folder_ / "result.csv";
  }
  ~ReportFile() override { std::filesystem::remove_all(folder_); }

  Report::Description description(bool resume, const std::string& quick = "no") const {
    const std::vector<std::pair<std::string, std::string>> options = {{"quick", quick}};
    return {"experiment", file, sidecar("experiment", command_line, options, 1), resume};
  }

  std::string file;

 private:
  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("lanc-report-" + std::to_string(::getpid()));
};

TEST(Csv, fields_with_commas_quotes_and_line_breaks_survive_the_round_trip) {
  const std::vector<std::string> fields = {"plain", "", "a,b", "say \"so\"", "two\nlines", "carriage\r\nreturn", "\""};
  std::string line;
  for (const auto& field : fields) line += (line.empty() ? "" : ",") + csv_field(field);
  const auto records = read_csv(line + "\n");
  ASSERT_EQ(records.size(), 1U);
  EXPECT_EQ(records[0].fields, fields);
  EXPECT_EQ(csv_field("plain"), "plain");
  EXPECT_EQ(csv_field("say \"so\""), "\"say \"\"so\"\"\"");
}

TEST(Csv, a_record_that_was_cut_off_is_left_out) {
  EXPECT_EQ(read_csv("a,b\nc,d").size(), 1U);
  EXPECT_EQ(read_csv("a,b\nc,\"d\n").size(), 1U);
  EXPECT_EQ(read_csv("a,b\r\nc,d\r\n")[1].fields, (std::vector<std::string>{"c", "d"}));
}

TEST(Csv, numbers_read_back_as_the_same_double) {
  for (const double x : {0.1, 1.0 / 3, 6.02214076e23, 5e-324, -0.0, 123456789.125, 1e22}) {
    const std::string text = csv_number(x);
    EXPECT_EQ(std::strtod(text.c_str(), nullptr), x) << text;
  }
  EXPECT_EQ(csv_number(0.1), "0.1");
  EXPECT_EQ(csv_number(std::numeric_limits<double>::quiet_NaN()), "");
  EXPECT_EQ(csv_number(std::numeric_limits<double>::infinity()), "");
}

TEST(Csv, a_row_survives_the_round_trip) {
  Cell c = cell("chain:3,\"odd\"");
  c.parameters = "a=1;b=2";
  const auto records = read_csv(csv_line("experiment", c, {"total", "time", 0.1, "s", "redundant"}));
  ASSERT_EQ(records.size(), 1U);
  const Row row = csv_row(records[0].fields);
  EXPECT_EQ(row.cell.model, c.model);
  EXPECT_EQ(row.cell.parameters, c.parameters);
  EXPECT_EQ(row.cell.seed, c.seed);
  EXPECT_EQ(row.cell.repetition, c.repetition);
  EXPECT_EQ(row.measurement.value, 0.1);
  EXPECT_EQ(row.measurement.status, "redundant");
}

TEST_F(ReportFile, continues_after_truncation_without_the_cell_that_was_cut) {
  {
    Report report(description(false));
    report.write(cell("a"), two_rows);
    report.write(cell("b"), two_rows);
    report.write(cell("c"), two_rows);
  }
  const std::string whole = contents(file);
  std::filesystem::resize_file(file, whole.size() - 10);  // in the middle of the last row
  {
    Report report(description(true));
    EXPECT_TRUE(report.has(cell("a")));
    EXPECT_TRUE(report.has(cell("b")));
    EXPECT_FALSE(report.has(cell("c")));
    EXPECT_FALSE(report.has(cell("a", 1)));
    EXPECT_EQ(report.rows().size(), 4U);
    report.write(cell("c"), two_rows);
  }
  EXPECT_EQ(contents(file), whole);
}

TEST_F(ReportFile, runs_that_are_ended_at_their_start_cost_one_cell_at_most) {
  {
    Report report(description(false));
    for (const int k : {1, 2, 3}) report.write(cell("a", k), two_rows);
  }
  const std::string before = contents(file);
  for (int start = 0; start < 3; ++start) {
    const Report report(description(true));  // and nothing is written
    EXPECT_TRUE(report.has(cell("a", 2)));
    EXPECT_FALSE(report.has(cell("a", 3)));
  }
  EXPECT_EQ(contents(file), before);
  Report report(description(true));
  report.write(cell("a", 3), two_rows);
  report.finish();
  EXPECT_EQ(contents(file), before);
}

TEST_F(ReportFile, a_finished_csv_has_nothing_left_to_do) {
  {
    Report report(description(false));
    report.write(cell("a"), two_rows);
    report.finish();
  }
  const std::string whole = contents(file);
  Report report(description(true));
  EXPECT_TRUE(report.has(cell("a")));
  EXPECT_EQ(contents(file), whole);
}

TEST_F(ReportFile, a_csv_of_other_options_is_not_continued) {
  { Report report(description(false)); }
  try {
    Report report(description(true, "yes"));
    FAIL() << "continued";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("options"), std::string::npos) << error.what();
  }
  std::filesystem::remove(std::filesystem::path(file).replace_extension(".json"));
  EXPECT_THROW(Report report(description(true)), InputError);
}

TEST_F(ReportFile, interruption_exits_130_and_leaves_a_valid_csv) {
  EXPECT_EXIT(
      {
        Report report(description(false));
        report.write(cell("a"), two_rows);
        std::raise(SIGINT);
      },
      ::testing::ExitedWithCode(130), "interrupted");
  const std::string text = contents(file);
  const auto records = read_csv(text);
  ASSERT_EQ(records.size(), 3U);
  EXPECT_EQ(records.back().end, text.size());
  for (const auto& record : records) EXPECT_EQ(record.fields.size(), csv_columns().size());
}

TEST_F(ReportFile, a_folder_that_is_not_there_is_told) {
  file = "no/such/folder/result.csv";
  EXPECT_THROW(Report report(description(false)), InputError);
}

TEST(Sidecar, tells_version_commit_compiler_processor_and_command_line) {
  const std::vector<std::pair<std::string, std::string>> options = {{"quick", "yes"}};
  const std::vector<std::pair<std::string, std::string>> libraries = {{"another", "1.2.3"}};
  const auto json = nlohmann::json::parse(sidecar("experiment", command_line, options, 7, libraries));
  for (const char* key :
       {"experiment", "version", "commit", "dirty", "compiler", "flags", "build_type", "optimised", "sanitized", "cpu",
        "threads", "libraries", "command_line", "options", "seed", "date", "finished"})
    EXPECT_TRUE(json.contains(key)) << key;
  EXPECT_EQ(json["seed"], 7);
  EXPECT_EQ(json["command_line"].size(), 2U);
  EXPECT_EQ(json["options"]["quick"], "yes");
  EXPECT_TRUE(json["libraries"].contains("SuiteSparse"));
  EXPECT_EQ(json["libraries"]["another"], "1.2.3");
  EXPECT_FALSE(json["finished"]);
}

TEST(Sidecar, an_unoptimised_build_is_warned_of) {
  BuildInfo info;
  info.optimised = true;
  EXPECT_FALSE(build_warning(info));
  info.optimised = false;
  EXPECT_TRUE(build_warning(info));
}

}  // namespace
}  // namespace lanc
