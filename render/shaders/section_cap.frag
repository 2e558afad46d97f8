// Cut faces of closed meshes.
#include "kept_ray.glsl"
#include "sample_place.glsl"
#include "payload.glsl"
#include "section_cells.glsl"
#define SURFACE_DEPTH gl_FragDepth
#include "shading.glsl"
#include "hatching.glsl"

const int kLongestList = 256;

// Record of the mesh that the cut point is in: the sum of records if it is in one mesh, otherwise the lowest record.
uint record_at(Cell cell) {
  if (cell.winding == 1) return cell.records - 1u;
  uint found = 0xffffffffu;
  int steps = 0;
  for (uint i = cell.head; i != 0u && steps < kLongestList; i = nodes[i - 1u].next, ++steps) {
    uint record = nodes[i - 1u].crossing >> 1;
    if (record >= found) continue;
    int winding = 0, counted = 0;
    for (uint j = cell.head; j != 0u && counted < kLongestList; j = nodes[j - 1u].next, ++counted)
      if (nodes[j - 1u].crossing >> 1 == record) winding += (nodes[j - 1u].crossing & 1u) != 0u ? 1 : -1;
    if (winding > 0) found = record;
  }
  return found;
}

void main() {
  Cell cell = cells[cell_of_pixel()];
  if (cell.winding < 1) discard;
  uint record = record_at(cell);
  if (record == 0xffffffffu) discard;
  uvec4 words = payload_texel(record, 4, 3);  // chunk, item id, material and flags
  if (dithered_away(words.z, words.y)) discard;
#ifdef SAMPLES
  gl_SampleMask[0] = 1 << gl_SampleID;  // crossings are those of the pixel, depths those of each sample
#endif
  vec2 place = fragment_place();
  int section;
  begins_cut(place, section);
  gl_FragDepth = depth_at(cut_depth(place, section));
  float hatch = hatch_cover(place, section, words.y);
  write_surface(cut_normal(section), eye_direction(place), hatch, words.z, words.y);
}
