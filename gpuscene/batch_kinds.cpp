#include "sightline/gpuscene/internal/batch_kinds.h"

#include <cctype>

namespace sightline::gpuscene {
namespace {

std::string in_capitals(std::string_view name) {
  std::string capitals(name);
  for (char& c : capitals) c = char(std::toupper(static_cast<unsigned char>(c)));
  return capitals;
}

}  // namespace

std::vector<std::string> batch_defines(BatchKind kind) {
  return {in_capitals(name_of(kind)), "TEXELS_PER_RECORD " + std::to_string(texels_per_record(kind))};
}

std::vector<std::string> batch_kind_defines() {
  std::vector<std::string> defines;
  for (int kind = 0; kind < kBatchKindCount; ++kind)
    defines.push_back(in_capitals(name_of(BatchKind(kind))) + "_KIND " + std::to_string(kind) + "u");
  return defines;
}

}  // namespace sightline::gpuscene
