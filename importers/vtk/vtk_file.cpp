#include "sightline/importers/vtk/internal/vtk_file.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <limits>
#include <type_traits>

#include <fmt/format.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkTypeInt64Array.h>
#include <vtkUnsignedCharArray.h>

#include "sightline/importers/internal/text_scanner.h"

namespace sightline::importers {
namespace {

/// Calls use() with a value of the number's type.
template <class Use>
void with_type(Number number, Use&& use) {
  switch (number) {
    case Number::kInt8:
      return use(std::int8_t{});
    case Number::kUInt8:
      return use(std::uint8_t{});
    case Number::kInt16:
      return use(std::int16_t{});
    case Number::kUInt16:
      return use(std::uint16_t{});
    case Number::kInt32:
      return use(std::int32_t{});
    case Number::kUInt32:
      return use(std::uint32_t{});
    case Number::kInt64:
      return use(std::int64_t{});
    case Number::kUInt64:
      return use(std::uint64_t{});
    case Number::kFloat:
      return use(float{});
    case Number::kDouble:
      return use(double{});
  }
}

template <class T>
T load(const std::byte* from, bool swap) {
  std::byte raw[sizeof(T)];
  std::memcpy(raw, from, sizeof(T));
  if (swap) std::reverse(std::begin(raw), std::end(raw));
  return std::bit_cast<T>(raw);
}

template <class To>
void fill(To* to, std::size_t count, Number from, const std::byte* data, bool swap) {
  with_type(from, [&]<class From>(From) {
    if constexpr (std::is_integral_v<To> && std::is_floating_point_v<From>) {
      return;  // make_array() refused it
    } else {
      for (std::size_t i = 0; i < count; ++i) to[i] = To(load<From>(data + i * sizeof(From), swap));
    }
  });
}

template <class T>
bool parse(std::string_view word, T& value) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
  if constexpr (std::is_floating_point_v<T>)  // too small for T, or too large, which is dropped later
    if (code == std::errc::result_out_of_range)
      value = word.find("e-") != std::string_view::npos ? T(0) : std::numeric_limits<T>::infinity();
  return end == word.data() + word.size() && !word.empty() &&
         (code == std::errc() || (std::is_floating_point_v<T> && code == std::errc::result_out_of_range));
}

template <class T>
core::Expected<std::size_t> fill(T* to, std::size_t count, std::string_view text, const VtkFile& file,
                                 std::size_t text_at) {
  constexpr std::size_t kStep = std::size_t{1} << 16;
  std::size_t at = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (i % kStep == kStep - 1)
      if (auto asked = file.progress(text_at + at); !asked) return tl::unexpected(asked.error());
    const std::string_view word = next_word(text, at);
    if (!parse(word, to[i]))
      return file.fail(text_at + at,
                       fmt::format("expected a number ({} of {}), found '{}'", i + 1, count, word.substr(0, 40)));
  }
  return at;
}

}  // namespace

tl::unexpected<core::Error> VtkFile::fail(std::size_t at, std::string_view message) const {
  return core::fail(fmt::format("{}: {}byte {}: {}", job().file(), part, at, message));
}

core::Expected<void> VtkFile::damage(std::size_t at, std::string_view message) const {
  return job().damage(at, fmt::format("{}byte {}: {}", part, at, message));
}

core::Expected<void> VtkFile::claim(std::size_t at, std::uint64_t count, std::size_t size) {
  const std::size_t most = kVtkDecodedFactor * bytes.size() + kVtkDecodedConstant;
  if (count > (most - claimed) / size)
    return fail(at, fmt::format("expected arrays of at most {} bytes in all in a file of {} bytes, found one of {} "
                                "values of {} bytes",
                                most, bytes.size(), count, size));
  claimed += std::size_t(count) * size;
  return {};
}

vtkSmartPointer<vtkDataArray> make_array(Wanted wanted, Number from, std::size_t count) {
  vtkSmartPointer<vtkDataArray> array;
  const bool integers = from < Number::kFloat;
  if (wanted == Wanted::kPoints) array = vtkSmartPointer<vtkDoubleArray>::New();
  if (wanted == Wanted::kNormals) array = vtkSmartPointer<vtkFloatArray>::New();
  if (wanted == Wanted::kIds && integers) array = vtkSmartPointer<vtkTypeInt64Array>::New();
  if (wanted == Wanted::kBytes && bytes_of(from) == 1) array = vtkSmartPointer<vtkUnsignedCharArray>::New();
  if (array) array->SetNumberOfTuples(vtkIdType(count));
  return array;
}

void fill_from_raw(vtkDataArray& to, Number from, std::span<const std::byte> data, bool big_endian) {
  const bool swap = big_endian != (std::endian::native == std::endian::big);
  const auto count = std::size_t(to.GetNumberOfValues());
  if (auto* points = vtkDoubleArray::SafeDownCast(&to)) fill(points->GetPointer(0), count, from, data.data(), swap);
  if (auto* normals = vtkFloatArray::SafeDownCast(&to)) fill(normals->GetPointer(0), count, from, data.data(), swap);
  if (auto* ids = vtkTypeInt64Array::SafeDownCast(&to)) fill(ids->GetPointer(0), count, from, data.data(), swap);
  if (auto* small = vtkUnsignedCharArray::SafeDownCast(&to)) fill(small->GetPointer(0), count, from, data.data(), swap);
}

core::Expected<std::size_t> fill_from_text(vtkDataArray& to, std::string_view text, const VtkFile& file,
                                           std::size_t at) {
  const auto count = std::size_t(to.GetNumberOfValues());
  if (auto* points = vtkDoubleArray::SafeDownCast(&to)) return fill(points->GetPointer(0), count, text, file, at);
  if (auto* normals = vtkFloatArray::SafeDownCast(&to)) return fill(normals->GetPointer(0), count, text, file, at);
  if (auto* ids = vtkTypeInt64Array::SafeDownCast(&to)) return fill(ids->GetPointer(0), count, text, file, at);
  return fill(static_cast<vtkUnsignedCharArray&>(to).GetPointer(0), count, text, file, at);
}

std::string_view next_word(std::string_view text, std::size_t& at) {
  while (at < text.size() && is_space(text[at])) ++at;
  const std::size_t begin = at;
  while (at < text.size() && !is_space(text[at])) ++at;
  return text.substr(begin, at - begin);
}

bool parse_count(std::string_view word, std::uint64_t& count) {
  return parse(word, count);
}

}  // namespace sightline::importers
