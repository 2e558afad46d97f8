// Images: tiles of large ones, outlines over them, what they lack, and what culling makes of their items.
#include <vector>

#include "sightline/bindings/c/internal/engines.h"
#include "sightline/engine/image_tiles.h"

using namespace sightline;
using namespace sightline::capi;

namespace {

sl_cropped_tile tile_of(const engine::CroppedTile& from) {
  return {{from.tile.width, from.tile.height, from.tile.x, from.tile.y}, from.x0, from.y0, from.x1, from.y1};
}

/// By item, of states by slot.
std::vector<std::uint8_t> states_by_item(const culling::CullStates& from, const core::Snapshot& snapshot,
                                         std::size_t items) {
  std::vector<std::uint8_t> states(items, SL_CULL_OUTSIDE);
  for (std::size_t slot = 0; slot < from.of_slot.size(); ++slot)
    if (const auto s = core::Slot(slot); !snapshot.vacant(s) && to_index(snapshot.item(s)) < items)
      states[to_index(snapshot.item(s))] = std::uint8_t(from.of_slot[slot]);
  return states;
}

sl_cull_box cull_box_of(const culling::CullBox& from, const core::dvec3& origin) {
  const core::AabbD box{origin + core::dvec3(from.box.min), origin + core::dvec3(from.box.max)};
  return {box_of(box), std::int32_t(from.state), from.items};
}

}  // namespace

sl_status sl_engine_frame_tile(sl_engine handle, const sl_view* whole, const sl_image_tile* tile,
                               sl_frame_report* report) {
  return with_engine(__func__, handle, Access::kEdit, [&](const EngineUse& engine) {
    if (report) check_result(report);
    require(tile != nullptr, "a tile, found null");
    const engine::ImageTile translated{tile->width, tile->height, tile->x, tile->y};
    const engine::FrameReport done = value_of(engine->frame_tile(view_of(whole), translated));
    if (report) write(report, report_of(done));
  });
}

sl_status sl_image_tiles(int32_t width, int32_t height, int32_t largest_side, int32_t more_margin, int32_t* tile_width,
                         int32_t* tile_height, sl_cropped_tile* tiles, size_t capacity, size_t* count) {
  return call(__func__, [&] {
    require(tile_width != nullptr && tile_height != nullptr, "room for the size of tiles, found null");
    check_buffer(tiles, capacity);
    check_result(count);
    constexpr std::int32_t kMost = 1 << 18;  // more would be more tiles than memory holds
    require(width <= kMost && height <= kMost && largest_side <= kMost && more_margin <= kMost,
            "sizes and margins of at most 262144 pixels");
    const engine::ImageTiles made = value_of(engine::image_tiles(width, height, largest_side, more_margin));
    *tile_width = made.width, *tile_height = made.height;
    write_list(made.tiles, tiles, capacity, count, tile_of);
  });
}

sl_status sl_engine_draw_outline(sl_engine handle, const sl_view* view, const sl_item* items, size_t item_count,
                                 const sl_external_target* target) {
  return with_engine(__func__, handle, Access::kEdit, [&](const EngineUse& engine) {
    check_drawing(true);
#if SIGHTLINE_HAS_GL
    value_of(engine->draw_outline(view_of(view), items_of(items, item_count), target_of(target)));
#else
    (void)engine, (void)view, (void)items, (void)item_count, (void)target;
#endif
  });
}

sl_status sl_engine_loss(sl_engine handle, const sl_view* view, sl_loss_report* report) {
  return with_engine(__func__, handle, Access::kEdit, [&](const EngineUse& engine) {
    check_result(report);
    const engine::LossReport loss = value_of(engine->loss(view_of(view)));
    write(report,
          {0, 0, loss.items, loss.pixels, loss.lod_error, loss.triangles, loss.full_triangles, loss.coarser_share, loss.coarseness});
  });
}

sl_status sl_engine_cull_states(sl_engine handle, const sl_view* view, sl_cull_states* states) {
  return with_engine(__func__, handle, Access::kEdit, [&](const EngineUse& engine) {
    sl_cull_states to = read(states, sl_cull_states SL_CULL_STATES_INIT);
    check_buffer(to.of_item, to.item_capacity);
    check_buffer(to.boxes, to.box_capacity);
    const culling::CullStates found = value_of(engine->cull_states(view_of(view)));
    std::copy(found.items.begin(), found.items.end(), to.items);
    const core::Snapshot& snapshot = engine->snapshot();
    write_list(states_by_item(found, snapshot, engine.scene()->item_slots()), to.of_item, to.item_capacity,
               &to.item_count);
    write_list(found.boxes, to.boxes, to.box_capacity, &to.box_count,
               [&](const culling::CullBox& box) { return cull_box_of(box, snapshot.bounds().origin); });
    write(states, to);
  });
}

sl_status sl_engine_covered(sl_engine handle, int32_t* covered) {
  return with_engine(__func__, handle, Access::kRead, [&](const EngineUse& engine) {
    check_drawing(true);
    check_result(covered);
#if SIGHTLINE_HAS_GL
    *covered = value_of(engine->covered());
#else
    (void)engine;
#endif
  });
}

sl_status sl_engine_framebuffer(sl_engine handle, uint32_t* framebuffer) {
  return with_engine(__func__, handle, Access::kRead, [&](const EngineUse& engine) {
    check_drawing(true);
    check_result(framebuffer);
#if SIGHTLINE_HAS_GL
    *framebuffer = value_of(engine->framebuffer());
#else
    (void)engine;
#endif
  });
}
