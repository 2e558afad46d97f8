// glTF files, their buffers and images behind the separator, and GLB files.
#include "sightline/importers/gltf/internal/gltf_reader.h"
#include "sightline/tests/fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sightline;
  const std::string_view text = fuzz::text_of(data, size);
  // 64 Mpixel, in the decoder's form and in ours; what has no textures gets nothing for them.
  constexpr std::size_t kTextureBytes = (std::size_t{64} << 20) * (8 + 8 + 4);
  const std::size_t spare = text.find("images") == text.npos ? 0 : kTextureBytes;
  // What is decompressed counts as the file's, at most 64 bytes for each.
  const std::size_t inflated = text.find("_compression") == text.npos ? 1 : 65;
  fuzz::check_reader(importers::read_gltf, text.starts_with("glTF") ? "fuzz.glb" : "fuzz.gltf",
                     fuzz::bytes_of(data, size),
                     {importers::kGltfMemoryFactor * inflated, importers::kGltfMemoryConstant + spare});
  return 0;
}
