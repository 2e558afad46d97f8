#include "sightline/importers/vtk/internal/vtk_file.h"

#include <charconv>
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

template <class To>
void fill(To* to, std::size_t count, Number from, const std::byte* data, bool big_endian) {
  with_type(from, [&]<class From>(From) {
    if constexpr (std::is_integral_v<To> && std::is_floating_point_v<From>) {
      return;  // make_array() refused it
    } else {
      for (std::size_t i = 0; i < count; ++i, data += sizeof(From))
        to[i] = To(big_endian ? load<From, std::endian::big>(data) : load<From, std::endian::little>(data));
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
std::size_t fill(T* to, std::size_t count, std::string_view text, const VtkFile& file, std::size_t text_at) {
  constexpr std::size_t kStep = std::size_t{1} << 16;
  std::size_t at = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (i % kStep == kStep - 1) file.progress(text_at + at);
    const std::string_view word = next_word(text, at);
    if (!parse(word, to[i]))
      file.fail(text_at + at,
                fmt::format("expected a number ({} of {}), found '{}'", i + 1, count, word.substr(0, 40)));
  }
  return at;
}

}  // namespace

void VtkFile::fail(std::size_t at, std::string_view message) const {
  throw ImportFault{{fmt::format("{}: {}byte {}: {}", job().file(), part, at, message)}};
}

void VtkFile::claim(std::size_t at, std::uint64_t count, std::size_t size) {
  const std::size_t most = kVtkDecodedFactor * bytes.size() + kVtkDecodedConstant;
  if (count > (most - claimed) / size)
    fail(at, fmt::format("expected arrays of at most {} bytes in all in a file of {} bytes, found one of {} "
                         "values of {} bytes",
                         most, bytes.size(), count, size));
  claimed += std::size_t(count) * size;
}

vtkSmartPointer<vtkDataArray> make_array(Wanted wanted, Number from, std::size_t count) {
  vtkSmartPointer<vtkDataArray> array;
  const bool integers = from < Number::kFloat;
  if (wanted == Wanted::kPoints) array = vtkSmartPointer<vtkDoubleArray>::New();
  if (wanted == Wanted::kNormals) array = vtkSmartPointer<vtkFloatArray>::New();
  if (wanted == Wanted::kIds && integers) array = vtkSmartPointer<vtkTypeInt64Array>::New();
  if (wanted == Wanted::kBytes && size_of(from) == 1) array = vtkSmartPointer<vtkUnsignedCharArray>::New();
  if (array) array->SetNumberOfTuples(vtkIdType(count));
  return array;
}

void fill_from_raw(vtkDataArray& to, Number from, std::span<const std::byte> data, bool big_endian) {
  const auto count = std::size_t(to.GetNumberOfValues());
  if (auto* points = vtkDoubleArray::SafeDownCast(&to))
    fill(points->GetPointer(0), count, from, data.data(), big_endian);
  if (auto* normals = vtkFloatArray::SafeDownCast(&to))
    fill(normals->GetPointer(0), count, from, data.data(), big_endian);
  if (auto* ids = vtkTypeInt64Array::SafeDownCast(&to)) fill(ids->GetPointer(0), count, from, data.data(), big_endian);
  if (auto* small = vtkUnsignedCharArray::SafeDownCast(&to))
    fill(small->GetPointer(0), count, from, data.data(), big_endian);
}

std::size_t fill_from_text(vtkDataArray& to, std::string_view text, const VtkFile& file, std::size_t at) {
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
