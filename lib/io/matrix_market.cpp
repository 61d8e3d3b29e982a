#include "lib/io/matrix_market.h"

#include <fmt/format.h>

#include "lib/model/error.h"

namespace lanc {
namespace {

std::FILE* open(const std::string& path) {
  std::FILE* file = std::fopen(path.c_str(), "w");
  if (file == nullptr) throw InputError(Place{path}, "this file cannot be written");
  return file;
}

}  // namespace

MatrixMarket::MatrixMarket(const std::string& path, const std::string& comment, const Shape& shape)
    : path_(path), file_(open(path)) {
  fmt::print(file_.get(), "%%MatrixMarket matrix coordinate real {}\n% {}\n{} {} {}\n",
             shape.symmetric ? "symmetric" : "general", comment, shape.rows, shape.columns, shape.entries);
}

void MatrixMarket::entry(int row, int column, double value) {
  fmt::print(file_.get(), "{} {} {}\n", row + 1, column + 1, value);
}

void MatrixMarket::finish() {
  if (std::ferror(file_.get()) != 0 || std::fclose(file_.release()) != 0)
    throw InputError(Place{path_}, "writing failed; is the disk full?");
}

void write_matrix_market(const std::string& path, const std::string& comment, const std::vector<double>& vector) {
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(open(path), std::fclose);
  fmt::print(file.get(), "%%MatrixMarket matrix array real general\n% {}\n{} 1\n", comment, vector.size());
  for (const double x : vector) fmt::print(file.get(), "{}\n", x);
  if (std::ferror(file.get()) != 0 || std::fclose(file.release()) != 0)
    throw InputError(Place{path}, "writing failed; is the disk full?");
}

}  // namespace lanc
