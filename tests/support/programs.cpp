#include "tests/support/programs.h"

#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

namespace lanc::test {
namespace {

namespace fs = std::filesystem;

std::string quoted(const std::string& word) {
  std::string text(1, '\'');
  for (const char c : word) {
    if (c == '\'')
      text += "'\\''";
    else
      text += c;
  }
  text += '\'';
  return text;
}

}  // namespace

const fs::path& folder() {
  struct Temporary {
    fs::path path = fs::temp_directory_path() / ("lanc-cli-test-" + std::to_string(::getpid()));
    Temporary() { fs::create_directories(path); }
    ~Temporary() { fs::remove_all(path); }
  };
  static const Temporary temporary;
  return temporary.path;
}

std::string text_of(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string write(const std::string& name, const std::string& text) {
  std::ofstream(folder() / name) << text;
  return (folder() / name).string();
}

Finished run(const std::string& program, const Words& arguments) {
  const fs::path bin = fs::read_symlink("/proc/self/exe").parent_path();
  const fs::path out = folder() / "stdout", error = folder() / "stderr";
  std::ostringstream command;
  command << quoted((bin / program).string());
  for (const std::string& argument : arguments) command << ' ' << quoted(argument);
  command << " >" << quoted(out.string()) << " 2>" << quoted(error.string()) << " </dev/null";
  const int status = std::system(command.str().c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text_of(out), text_of(error)};
}

}  // namespace lanc::test
