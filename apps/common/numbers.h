// Numbers and lengths as tools write them for people.
#pragma once

#include <cstdint>
#include <string>

#include "sightline/core/conventions.h"

namespace sightline::apps {

std::string grouped(std::int64_t number);  ///< 1,234,567
std::string vector_text(const core::dvec3& v);
std::string bytes_text(std::uint64_t bytes);  ///< 1.5 kB, 20.3 MB
std::string length_text(double metres);       ///< 1.250 m, 0.13 mm

enum class Units { kAutomatic, kMillimetres, kMetres, kFeet };
inline constexpr const char* kUnitsNames[] = {"auto", "mm", "m", "ft"};

/// How lengths of a model are written.
struct LengthFormat {
  Units units = Units::kMetres;  ///< not kAutomatic
  int decimals = kTrimmed;
  static constexpr int kTrimmed = -1;  ///< six without zeros at the end; three for places

  std::string number(double metres) const;           ///< 12,346
  std::string plain(double metres) const;            ///< 12346, for programs
  std::string text(double metres) const;             ///< 12,346 mm
  std::string text(const core::dvec3& place) const;  ///< three numbers, without the unit
  double per_metre() const;
  const char* unit() const { return kUnitsNames[int(units)]; }
};

/// Automatic: millimetres. Lengths of a plant have no decimals in millimetres; those of other models have the more the
/// smaller the model is. `size`: the model's largest extent, metres; `plant`: whether it is one whatever its size.
LengthFormat length_format(Units chosen, double size, bool plant);

/// The text with spaces at which a line may not end: between a number and its unit.
std::string unbroken(const std::string& text);

}  // namespace sightline::apps
