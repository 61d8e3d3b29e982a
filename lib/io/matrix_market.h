// Matrices as files that MATLAB, SciPy, Julia and Eigen read: Matrix Market exchange format.
#pragma once

#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

namespace lanc {

/// Writes a coordinate matrix entry by entry. Eigen's own writer pads numbers to 64 digits and writes symmetric
/// matrices twice. Throws InputError when the file cannot be written.
class MatrixMarket {
 public:
  struct Shape {
    int rows = 0, columns = 0;
    std::int64_t entries = 0;
    bool symmetric = false;  // then only entries on and below the diagonal are given
  };
  MatrixMarket(const std::string& path, const std::string& comment, const Shape& shape);

  /// Row and column from 0. The shortest decimal that reads back as the same double.
  void entry(int row, int column, double value);
  /// To be called last: tells whether everything was written.
  void finish();

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::string path_;
  std::unique_ptr<std::FILE, Close> file_;
};

/// A column vector, in array format.
void write_matrix_market(const std::string& path, const std::string& comment, const std::vector<double>& vector);

}  // namespace lanc
