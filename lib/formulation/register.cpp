#include <algorithm>

#include "lib/formulation/formulation.h"

namespace lanc {

namespace {
std::vector<FormulationInfo>& registered() {
  static std::vector<FormulationInfo> list;
  return list;
}
}  // namespace

Registration::Registration(const FormulationInfo& info) {
  auto& list = registered();
  list.insert(
      std::upper_bound(list.begin(), list.end(), info, [](const auto& a, const auto& b) { return a.name < b.name; }),
      info);
}

std::span<const FormulationInfo> formulations() { return registered(); }

const FormulationInfo* find_formulation(std::string_view name) {
  for (const FormulationInfo& info : formulations())
    if (info.name == name) return &info;
  return nullptr;
}

const FormulationInfo* default_formulation() {
  for (const FormulationInfo& info : formulations())
    if (info.recursive) return &info;
  return nullptr;
}

}  // namespace lanc
