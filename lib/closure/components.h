// Loops that hang together: closure rows are decided apart where they share no velocity.
#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

namespace lanc {

/// Some rows of G with all the velocities they have entries for; both ascending.
struct ClosureComponent {
  std::vector<int> rows, columns;

  int local_column(int column) const {
    return static_cast<int>(std::lower_bound(columns.begin(), columns.end(), column) - columns.begin());
  }
};

/// By the structure of G (starts and columns of its rows). Nearly linear in the entries.
inline std::vector<ClosureComponent> closure_components(const std::vector<int>& starts, const std::vector<int>& columns,
                                                        int velocities) {
  const int rows = static_cast<int>(starts.size()) - 1;
  std::vector<int> leader(rows), first_row(velocities, -1);
  std::iota(leader.begin(), leader.end(), 0);
  const auto find = [&](int k) {
    while (leader[k] != k) k = leader[k] = leader[leader[k]];
    return k;
  };
  for (int k = 0; k < rows; ++k)
    for (int p = starts[k]; p < starts[k + 1]; ++p) {
      int& row = first_row[columns[p]];
      if (row < 0) row = k;
      const int a = find(row), b = find(k);
      leader[std::max(a, b)] = std::min(a, b);
    }
  std::vector<ClosureComponent> components;
  std::vector<int> index(rows, -1);
  for (int k = 0; k < rows; ++k) {
    const int a = find(k);
    if (index[a] < 0) index[a] = static_cast<int>(components.size()), components.emplace_back();
    components[index[a]].rows.push_back(k);
  }
  for (int c = 0; c < velocities; ++c)
    if (first_row[c] >= 0) components[index[find(first_row[c])]].columns.push_back(c);
  return components;
}

}  // namespace lanc
