#include "lib/report/report.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <unordered_set>

#include "lib/model/error.h"
#include "lib/report/csv.h"

namespace lanc {

namespace {

constexpr std::array<std::string_view, 14> columns = {
    "experiment", "model",  "bodies", "velocities", "closure_rows", "formulation", "parameters",
    "phase",      "metric", "value",  "unit",       "seed",         "repetition",  "status"};

std::string header_line() { return fmt::format("{}\n", fmt::join(columns, ",")); }

template <class T>
std::string text_of(const std::optional<T>& value) {
  return value ? fmt::format("{}", *value) : std::string();
}

template <class T>
T number(const std::string& text) {
  T value{};
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  if (result.ec != std::errc() || result.ptr != text.data() + text.size())
    throw InputError(fmt::format("'{}' is no number", text));
  return value;
}

std::string key(const Cell& cell) {
  return fmt::format("{}\n{}\n{}\n{}\n{}", cell.model, cell.formulation, cell.parameters, text_of(cell.seed),
                     text_of(cell.repetition));
}

/// Ends the program at once; cells are written with this signal blocked, so what is in the file is whole.
extern "C" void leave(int signal) {
  constexpr char message[] = "\ninterrupted; the CSV holds every cell that was finished, --resume continues it\n";
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, message, sizeof message - 1);
  ::_exit(128 + signal);
}

sigset_t handled_signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  return set;
}

/// SIGINT and SIGTERM wait while one of these lives.
class SignalsBlocked {
 public:
  SignalsBlocked() {
    const sigset_t set = handled_signals();
    pthread_sigmask(SIG_BLOCK, &set, &before_);
  }
  ~SignalsBlocked() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }

 private:
  sigset_t before_;
};

void write_all(int file, std::string_view text, const std::string& name) {
  const SignalsBlocked blocked;
  while (!text.empty()) {
    const ssize_t n = ::write(file, text.data(), text.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) throw InputError(fmt::format("cannot write {}: {}", name, std::strerror(errno)));
    text.remove_prefix(static_cast<std::size_t>(n));
  }
}

}  // namespace

void replace_file(const std::string& name, const std::string& text) {
  const std::string part = name + ".part";
  std::ofstream out(part, std::ios::binary | std::ios::trunc);
  out << text;
  out.close();
  std::error_code error;
  if (out) std::filesystem::rename(part, name, error);
  if (out && !error) return;
  const std::string why = error ? error.message() : "the disk is full, or the file may not be that large";
  std::filesystem::remove(part, error);
  throw InputError(fmt::format("cannot write {}: {}", name, why));
}

namespace {

std::string contents(const std::string& name) {
  std::ifstream in(name, std::ios::binary);
  if (!in) throw InputError(fmt::format("cannot read {}", name));
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string sidecar_name(const std::string& csv) {
  std::string name = std::filesystem::path(csv).replace_extension(".json");
  if (name == csv) throw InputError(fmt::format("{} is the name of the JSON sidecar; call the CSV otherwise", csv));
  return name;
}

/// Throws unless the two sidecars agree in what decides the numbers.
void require_same(const std::string& file, const nlohmann::json& before, const nlohmann::json& now) {
  for (const char* what : {"experiment", "version", "commit", "dirty", "compiler", "flags", "cpu", "options"}) {
    const auto old = before.value(what, nlohmann::json()), present = now.value(what, nlohmann::json());
    if (old != present)
      throw InputError(
          fmt::format("{} cannot be continued: its sidecar says {} = {}, this run has {}; run it with the same options "
                      "and build, or without --resume, or choose another --out",
                      file, what, old.dump(), present.dump()));
  }
}

}  // namespace

std::span<const std::string_view> csv_columns() { return columns; }

std::string csv_line(std::string_view experiment, const Cell& cell, const Measurement& m) {
  return fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", csv_field(experiment), csv_field(cell.model),
                     cell.bodies, cell.velocities, cell.closure_rows, csv_field(cell.formulation),
                     csv_field(cell.parameters), csv_field(m.phase), csv_field(m.metric), csv_number(m.value),
                     csv_field(m.unit), text_of(cell.seed), text_of(cell.repetition), csv_field(m.status));
}

Row csv_row(std::span<const std::string> fields) {
  if (fields.size() != columns.size())
    throw InputError(fmt::format("a row of {} fields, not {}", fields.size(), columns.size()));
  Row row;
  row.cell.model = fields[1];
  row.cell.bodies = number<int>(fields[2]);
  row.cell.velocities = number<int>(fields[3]);
  row.cell.closure_rows = number<int>(fields[4]);
  row.cell.formulation = fields[5];
  row.cell.parameters = fields[6];
  row.measurement = {fields[7], fields[8],
                     fields[9].empty() ? std::numeric_limits<double>::quiet_NaN() : number<double>(fields[9]),
                     fields[10], fields[13]};
  if (!fields[11].empty()) row.cell.seed = number<std::uint64_t>(fields[11]);
  if (!fields[12].empty()) row.cell.repetition = number<int>(fields[12]);
  return row;
}

struct Report::State {
  Description description;
  int file = -1;
  off_t taken_over = -1;  // bytes, until cut()
  std::vector<Row> rows;
  std::unordered_set<std::string> cells;
  struct sigaction before_int, before_term;

  void begin() {
    if (description.file == "-") {
      file = STDOUT_FILENO;
    } else {
      open_file(O_CREAT | O_TRUNC);  // emptied first: an old CSV must not be taken for one of the new sidecar
      replace_file(sidecar_name(description.file), description.sidecar + "\n");
    }
    write_all(file, header_line(), description.file);
  }

  void open_file(int flags) {
    file = ::open(description.file.c_str(), O_WRONLY | O_CLOEXEC | flags, 0666);
    if (file < 0) throw InputError(fmt::format("cannot write {}: {}", description.file, std::strerror(errno)));
  }

  /// A run that was ended before it wrote its first line.
  bool nothing_to_resume() const {
    return !std::filesystem::exists(description.file) || read_csv(contents(description.file)).empty();
  }

  /// Takes over all cells but the last, which may be incomplete.
  void resume() {
    const std::string& name = description.file;
    if (!std::filesystem::exists(sidecar_name(name)))
      throw InputError(fmt::format("{} cannot be continued: its sidecar {} is missing", name, sidecar_name(name)));
    const auto before = nlohmann::json::parse(contents(sidecar_name(name)), nullptr, false);
    if (before.is_discarded())
      throw InputError(fmt::format("{} cannot be continued: {} is no JSON", name, sidecar_name(name)));
    require_same(name, before, nlohmann::json::parse(description.sidecar));

    const std::string text = contents(name);
    const auto records = read_csv(text);
    if (records.empty() ||
        !std::equal(columns.begin(), columns.end(), records[0].fields.begin(), records[0].fields.end()))
      throw InputError(fmt::format("{} cannot be continued: its first line is not the header of our columns", name));
    std::size_t whole = records[0].end, cell_begin = 0;
    std::string last;
    for (std::size_t i = 1; i < records.size(); ++i) {
      Row row;
      try {
        row = csv_row(records[i].fields);
      } catch (const InputError& error) {
        throw InputError(fmt::format("{} cannot be continued: row {}: {}", name, i + 1, error.what()));
      }
      if (std::string present = key(row.cell); i == 1 || present != last) {
        if (i > 1) cells.insert(last);
        last = std::move(present);
        whole = records[i - 1].end;
        cell_begin = rows.size();
      }
      rows.push_back(std::move(row));
    }
    if (before.value("finished", false)) {
      if (!last.empty()) cells.insert(last);
      whole = records.back().end;
    } else {
      rows.resize(cell_begin);
    }
    open_file(0);
    taken_over = static_cast<off_t>(whole);
  }

  /// Cuts off what resume() has not taken over. Not before there is something to write: a run that is ended at its
  /// start, again and again, must not cost a cell each time.
  void cut() {
    if (taken_over < 0) return;
    if (::ftruncate(file, taken_over) != 0 || ::lseek(file, 0, SEEK_END) < 0)
      throw InputError(fmt::format("cannot write {}: {}", description.file, std::strerror(errno)));
    taken_over = -1;
  }
};

Report::Report(const Description& description) : state_(std::make_unique<State>()) {
  state_->description = description;
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error of write(), told as such
  if (description.resume && description.file != "-" && !state_->nothing_to_resume())
    state_->resume();
  else
    state_->begin();
  struct sigaction action = {};
  action.sa_handler = leave;
  sigaction(SIGINT, &action, &state_->before_int);
  sigaction(SIGTERM, &action, &state_->before_term);
}

Report::~Report() {
  sigaction(SIGINT, &state_->before_int, nullptr);
  sigaction(SIGTERM, &state_->before_term, nullptr);
  if (state_->file > STDERR_FILENO) ::close(state_->file);
}

bool Report::has(const Cell& cell) const { return state_->cells.count(key(cell)) > 0; }

void Report::write(const Cell& cell, std::span<const Measurement> measurements) {
  std::string text;
  for (const Measurement& m : measurements) {
    text += csv_line(state_->description.experiment, cell, m);
    state_->rows.push_back({cell, m});
    if (!std::isfinite(m.value)) state_->rows.back().measurement.value = std::numeric_limits<double>::quiet_NaN();
  }
  state_->cut();
  write_all(state_->file, text, state_->description.file);
}

const std::vector<Row>& Report::rows() const { return state_->rows; }

const std::string& Report::finish() {
  const Description& d = state_->description;
  state_->cut();
  if (d.file != "-") {
    auto sidecar = nlohmann::ordered_json::parse(d.sidecar);
    sidecar["finished"] = true;
    replace_file(sidecar_name(d.file), sidecar.dump(2) + "\n");
  }
  return d.file;
}

}  // namespace lanc
