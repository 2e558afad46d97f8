#include "random_calls.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>
#include <thread>
#include <vector>

#include "sightline/sightline.h"
#include "sightline/tests/support/places.h"

namespace sightline::tests {
namespace {

constexpr std::size_t kMostScenes = 4, kMostEngines = 4;  // alive at a time
constexpr std::size_t kRoom = 64;                         // of buffers for results

/// Bytes, and the values made of them; zeros at the end.
class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : at_(data), end_(data + size) {}

  bool used_up() const { return at_ == end_; }
  unsigned byte() { return at_ == end_ ? 0 : *at_++; }
  unsigned below(unsigned n) { return byte() % n; }
  bool one_in(unsigned n) { return byte() % n == n - 1; }
  std::uint64_t word() {
    std::uint64_t value = 0;
    for (int i = 0; i < 8; ++i) value = value << 8 | byte();
    return value;
  }
  std::int32_t integer() {
    constexpr std::int32_t kOdd[] = {
        -1, 0, 5, 100, 70'000, std::numeric_limits<std::int32_t>::max(), std::numeric_limits<std::int32_t>::min()};
    return one_in(16) ? kOdd[below(7)] : std::int32_t(below(4));
  }
  double number() {
    constexpr double kOdd[] = {std::numeric_limits<double>::quiet_NaN(),
                               std::numeric_limits<double>::infinity(),
                               -std::numeric_limits<double>::infinity(),
                               1e300,
                               -1e300,
                               1e38,
                               5e-324,
                               -0.0};
    if (one_in(64)) return kOdd[below(8)];
    return (int(byte()) - 128) * 0.125;
  }
  float small() { return one_in(64) ? float(number()) : float(below(9)) * 0.25f; }

 private:
  const std::uint8_t *at_, *end_;
};

class Sequence {
 public:
  Sequence(const std::uint8_t* data, std::size_t size, bool draws) : in_(data, size), draws_(draws) {}

  std::string run() {
    create_scene();
    while (!in_.used_up() && wrong_.empty()) step();
    for (const std::uint64_t engine : alive_.engines) expect(sl_engine_destroy({engine}) == SL_OK, "a live engine");
    for (const std::uint64_t scene : alive_.scenes) expect(sl_scene_destroy({scene}) == SL_OK, "a live scene");
    for (const std::uint64_t culler : alive_.cullers) expect(sl_box_culler_destroy({culler}) == SL_OK, "a live culler");
    return wrong_;
  }

 private:
  void expect(bool holds, const char* what) {
    if (!holds && wrong_.empty()) wrong_ = std::string("expected ") + what + "; last error: " + sl_last_error();
  }

  /// Checks the status of a call on a scene, engine or culler against the object's liveness.
  sl_status check(sl_status status, std::uint64_t object, const std::set<std::uint64_t>& alive) {
    expect(status >= SL_OK && status <= SL_ERROR_UNSUPPORTED && status != SL_ERROR_MEMORY, "a status, and memory");
    expect(status == SL_OK || *sl_last_error() != '\0', "a message");
    if (!alive.count(object))
      expect(status == SL_ERROR_HANDLE || status == SL_ERROR_ARGUMENT || status == SL_ERROR_UNSUPPORTED,
             "an error for a dead handle");
    expect(status != SL_ERROR_THREAD, "the right thread");
    return status;
  }
  sl_status check(sl_status status, sl_scene scene) { return check(status, scene.id, alive_.scenes); }
  sl_status check(sl_status status, sl_engine engine) { return check(status, engine.id, alive_.engines); }
  sl_status check(sl_status status, sl_box_culler culler) { return check(status, culler.id, alive_.cullers); }

  /// Checks the status of a function that destroys one of `alive`.
  void check_end(sl_status status, std::uint64_t object, std::set<std::uint64_t>& alive) {
    expect((status == SL_OK) == (alive.erase(object) == 1), "success for what lives, alone");
  }

  std::uint64_t any(const std::vector<std::uint64_t>& of_kind) {
    switch (in_.below(24)) {
      case 0:
        return 0;
      case 1:
        return in_.word();
      case 2:
        return made_all_.empty() ? 0 : made_all_[in_.byte() % made_all_.size()];  // of any kind
      case 3:
        return of_kind.empty() ? 1 : of_kind[in_.byte() % of_kind.size()] ^ std::uint64_t(1) << in_.below(64);
      default:
        return of_kind.empty() ? 0
                               : of_kind[of_kind.size() - 1 - in_.byte() % std::min<std::size_t>(of_kind.size(), 24)];
    }
  }
  /// Mostly one that is alive.
  std::uint64_t any(const std::vector<std::uint64_t>& of_kind, const std::set<std::uint64_t>& alive) {
    if (alive.empty() || in_.one_in(8)) return any(of_kind);
    return *std::next(alive.begin(), std::ptrdiff_t(in_.byte() % alive.size()));
  }
  sl_scene scene() { return {any(made_.scenes, alive_.scenes)}; }
  sl_engine engine() { return {any(made_.engines, alive_.engines)}; }
  sl_box_culler culler() { return {any(made_.cullers)}; }
  sl_node node() { return {any(made_.nodes)}; }
  sl_mesh mesh() { return {any(made_.meshes)}; }
  sl_material material() { return {in_.one_in(2) ? 0 : any(made_.materials)}; }
  sl_item item() { return in_.one_in(32) ? sl_item(in_.word()) : sl_item(in_.below(48)); }

  void keep(std::vector<std::uint64_t>& of_kind, std::uint64_t handle) {
    const bool of_a_scene = &of_kind != &made_.scenes && &of_kind != &made_.engines && &of_kind != &made_.cullers;
    expect(handle != 0 && (of_a_scene || std::find(of_kind.begin(), of_kind.end(), handle) == of_kind.end()),
           "a new handle");
    of_kind.push_back(handle);
    made_all_.push_back(handle);
  }

  /// The identity moved, or any numbers; now and then null.
  const double* matrix() {
    if (in_.one_in(8)) return nullptr;
    std::fill(std::begin(matrix_), std::end(matrix_), 0.0);
    for (int i = 0; i < 16; i += 5) matrix_[i] = 1.0;
    for (int i = 12; i < 15; ++i) matrix_[i] = in_.number();
    if (in_.one_in(16)) matrix_[in_.below(16)] = in_.number();
    return matrix_;
  }
  const char* text() {
    constexpr const char* kTexts[] = {"", "a", "pump", "/", "\xff\xfe", "a longer name than most of the others have"};
    return in_.one_in(12) ? nullptr : kTexts[in_.below(6)];
  }
  sl_text* room_for_text() {
    text_ = {characters_, in_.below(kRoom), 0};
    if (in_.one_in(32)) text_.data = nullptr;
    return in_.one_in(32) ? nullptr : &text_;
  }
  template <class T>
  T* buffer(T (&room)[kRoom], std::size_t& capacity) {
    capacity = in_.below(kRoom + 1);
    return in_.one_in(16) ? nullptr : room;
  }
  std::size_t* count() { return in_.one_in(32) ? nullptr : &count_; }
  /// With the wrong size now and then.
  template <class T>
  T* sized(T& value) {
    if (in_.one_in(32)) value.size = std::uint32_t(in_.below(unsigned(sizeof(T))));
    return in_.one_in(32) ? nullptr : &value;
  }

  const sl_view* view() {
    view_ = SL_VIEW_INIT;
    const sl_pose pose = {{in_.number(), in_.number(), in_.number()}, {in_.number(), in_.number(), 0}, {0, 0, 1}};
    sl_status made = SL_OK;
    switch (in_.below(4)) {
      case 0:
        made = sl_view_orthographic(&pose, in_.number(), 1.5, in_.number(), in_.number(), &view_);
        break;
      case 1: {
        const double* eye = matrix();
        double clip[16];
        for (double& value : clip) value = in_.number();
        made = sl_view_from_matrices(eye, clip, in_.integer(), &view_);
        break;
      }
      default:
        made = sl_view_perspective(&pose, 0.8, 1.5, 0.1, in_.one_in(2) ? HUGE_VAL : 100.0, &view_);
    }
    if (made != SL_OK && in_.one_in(2)) return &view_;  // zeros all over
    if (in_.one_in(4)) {
      view_.section_count = in_.below(SL_MAX_SECTIONS + 2);
      for (sl_plane& plane : view_.sections) plane = {{in_.number(), in_.number(), in_.number()}, in_.number()};
      view_.section_mode = in_.one_in(16) ? in_.integer() : std::int32_t(in_.below(2));
    }
    if (in_.one_in(8)) view_.layers = in_.below(8);
    return sized(view_);
  }

  static std::int32_t progress(double, void* user) {
    auto& self = *static_cast<Sequence*>(user);
    self.expect(sl_scene_commit(self.importing_) != SL_OK, "a busy scene");
    return self.in_.byte() % 8 != 0;
  }

  void create_scene() {
    sl_scene made = {0};
    if (alive_.scenes.size() >= kMostScenes) return;
    expect(sl_scene_create(&made) == SL_OK, "a scene");
    keep(made_.scenes, made.id);
    alive_.scenes.insert(made.id);
    sl_scene_info info = SL_SCENE_INFO_INIT;
    expect(sl_scene_get(made, &info) == SL_OK, "a new scene's info");
    made_.nodes.push_back(info.root.id);
  }

  void create_engine() {
    sl_engine_config config = SL_ENGINE_CONFIG_INIT;
    config.culling.culler = in_.one_in(8) ? in_.integer() : std::int32_t(in_.below(3));
    if (!draws_ && config.culling.culler > SL_CULLER_CPU) config.culling.culler = in_.one_in(2) ? 5 : SL_CULLER_CPU;
    config.width = std::int32_t(1 + in_.below(64)), config.height = std::int32_t(1 + in_.below(64));
    if (in_.one_in(16)) config.width = -config.width;
    if (draws_) {
      config.draw = !in_.one_in(4);
      config.drawing.ids = in_.one_in(2);
      config.drawing.samples = in_.integer();
      config.context.gl_state = in_.integer();
      config.context.program_cache = "";
    }
    if (in_.one_in(8)) config.losses.min_projected_area = in_.small();
    if (in_.one_in(8)) config.losses.budget_ms = in_.number();
    if (in_.one_in(8)) config.culling.rebuild_share = in_.small();
    if (in_.one_in(16)) config.culling.occlusion = in_.integer();
    if (in_.one_in(16)) config.losses.contribution_mode = in_.integer();
    if (in_.one_in(16)) config.drawing.transparency = in_.integer();
    if (in_.one_in(16)) config.culling.gpu_variant = in_.integer();
    if (in_.one_in(16)) config.culling.part.index = in_.integer(), config.culling.part.count = in_.integer();
    if (in_.one_in(8))
      config.drawing.looks.depth_shading.strength = in_.small(),
      config.drawing.looks.depth_shading.edge_lines = in_.small();
    if (in_.one_in(8))
      config.drawing.looks.hatching.strength = in_.small(), config.drawing.looks.hatching.spacing = float(in_.number());
    if (in_.one_in(8)) config.culling.controller.margin = in_.number();
    if (in_.one_in(8)) config.culling.controller.dwell_frames = in_.below(4);
    const sl_scene of = scene();
    importing_ = of;
    const bool told = in_.one_in(4);
    if (told) config.progress = progress, config.progress_user = this;
    sl_engine made = {0};
    if (alive_.engines.size() >= kMostEngines) return;
    if (check(sl_engine_create(of, told ? &config : sized(config), in_.one_in(32) ? nullptr : &made), of) == SL_OK) {
      keep(made_.engines, made.id);
      alive_.engines.insert(made.id);
    }
  }

  void create_culler() {
    sl_box boxes[kRoom];
    const std::size_t boxes_used = in_.below(kRoom + 1);
    for (std::size_t i = 0; i < boxes_used; ++i)
      boxes[i] = {{in_.number(), in_.number(), in_.number()}, {in_.number(), in_.number(), in_.number()}};
    sl_box_culler made = {0};
    if (sl_box_culler_create(in_.one_in(16) ? nullptr : boxes, boxes_used, &made) != SL_OK) return;
    keep(made_.cullers, made.id);
    alive_.cullers.insert(made.id);
  }

  /// Copies of one box, as many as the culler may have.
  void change_boxes(sl_box_culler of, const sl_box& box) {
    sl_box boxes[kRoom];
    std::uint32_t indices[kRoom];
    std::fill_n(boxes, kRoom, box);
    for (std::uint32_t& index : indices) index = in_.below(in_.one_in(32) ? 70 : 3);
    const std::size_t used = in_.below(kRoom + 1);
    const sl_box* from = in_.one_in(16) ? nullptr : boxes;
    if (in_.one_in(4)) return look_behind(of, from, used);
    if (in_.one_in(2))
      check(sl_box_culler_refit(of, from, used), of);
    else
      check(sl_box_culler_update_many(of, in_.one_in(16) ? nullptr : indices, from, used), of);
  }

  /// Queries of a culler.
  void ask_boxes(sl_box_culler of, const sl_box& box) {
    std::uint32_t indices[kRoom];
    sl_box_hit hits[kRoom];
    std::size_t count = 0;
    sl_ray ray = SL_RAY_INIT;
    ray.origin[0] = in_.number(), ray.direction[2] = in_.number(), ray.t_max = in_.number();
    check(sl_box_culler_in_box(of, &box, in_.integer(), indices, in_.below(kRoom), &count), of);
    check(sl_box_culler_around(of, box.min, in_.number(), indices, in_.below(kRoom), &count), of);
    check(sl_box_culler_nearest(of, box.max, hits, in_.below(kRoom), &count), of);
    check(sl_box_culler_along(of, sized(ray), hits, in_.below(kRoom), &count), of);
  }
  /// A raster of occluders, from begin to end.
  void look_behind(sl_box_culler of, const sl_box* solids, std::size_t used) {
    sl_occluder_raster raster = {0};
    expect(sl_occluder_raster_create(&raster) == SL_OK, "a raster");
    const auto any_status = [&](sl_status status) { expect(status != SL_ERROR_MEMORY, "memory"); };
    any_status(sl_occluder_raster_begin(raster, view(), std::int32_t(in_.below(40)), std::int32_t(in_.below(40))));
    float corners[3 * 4];
    std::uint32_t indices[6], found[kRoom];
    for (float& value : corners) value = float(in_.number());
    for (std::uint32_t& index : indices) index = in_.below(in_.one_in(16) ? 5 : 4);
    sl_mesh_data mesh = {sizeof mesh, 4, nullptr, corners, nullptr, indices, 6};
    any_status(sl_occluder_raster_add_largest(raster, solids, used, in_.below(8), count()));
    any_status(sl_occluder_raster_add_cube(raster, matrix()));
    any_status(sl_occluder_raster_add_cylinder(raster, matrix(), std::int32_t(in_.below(18))));
    any_status(sl_occluder_raster_add_mesh(raster, sized(mesh), matrix()));
    float metres[kRoom];
    for (float& value : metres) value = float(in_.number());
    any_status(sl_occluder_raster_read(raster, in_.one_in(16) ? nullptr : metres, in_.below(kRoom)));
    check(sl_box_culler_visible_in_depth(of, view(), metres, 8, 8, found, kRoom, count()), of);
    const std::uint64_t behind = in_.one_in(16) ? any(made_.cullers) : raster.id;
    any_status(sl_box_culler_visible_behind(of, view(), {behind}, found, kRoom, count()));
    expect(sl_occluder_raster_destroy(raster) == SL_OK, "a live raster");
  }

  void add_mesh() {
    float corners[3 * 6];
    std::uint32_t indices[12];
    for (float& value : corners) value = float(in_.number());
    for (std::uint32_t& index : indices) index = in_.below(in_.one_in(32) ? 7 : 6);
    sl_mesh_data data = {sizeof data, 6, text(), corners, in_.one_in(2) ? corners : nullptr, indices, 12};
    if (in_.one_in(16)) data.index_count = in_.below(13);
    if (in_.one_in(32)) data.positions = nullptr;
    const sl_scene to = scene();
    sl_mesh made = {0};
    if (check(sl_mesh_add(to, sized(data), &made), to) == SL_OK) keep(made_.meshes, made.id);
  }

  void import_file() {
    const sl_scene to = scene();
    static const std::string box = in_checkout("tests/data/box.stl").string();
    const char* const files[] = {"no_such_file.rvm", box.c_str(), "."};
    const char* paths[2] = {in_.one_in(4) ? text() : files[in_.below(3)], files[in_.below(3)]};
    sl_import_options options = SL_IMPORT_OPTIONS_INIT;
    options.progress = progress, options.user = this;
    options.lenient = in_.integer(), options.up = in_.integer(), options.copies = in_.integer();
    options.metres_per_unit = in_.number();
    options.recognise = in_.integer(), options.recognise_tolerance = in_.number();
    importing_ = to;
    sl_node nodes[2];
    sl_import_report report = SL_IMPORT_REPORT_INIT;
    if (check(sl_import(to, node(), paths, in_.below(3), sized(options), nodes, sized(report)), to) == SL_OK)
      expect(report.triangles_after <= report.triangles_before, "no more triangles than there were");
  }

  /// A call on another thread. Live scenes and engines belong to this one.
  void call_elsewhere() {
    const sl_scene of = scene();
    const sl_engine by = engine();
    const unsigned which = in_.below(6);
    sl_status status = SL_OK;
    std::thread([&] {
      sl_scene_info info = SL_SCENE_INFO_INIT;
      switch (which) {
        case 0:
          status = sl_scene_destroy(of);
          break;
        case 1:
          status = sl_scene_get(of, &info);
          break;
        case 2:
          status = sl_scene_hand_over(of);
          break;
        case 3:
          status = sl_engine_commit(by);
          break;
        case 4:
          status = sl_engine_destroy(by);
          break;
        default:
          status = sl_engine_finish(by);
      }
    }).join();
    const bool lives = which < 3 ? alive_.scenes.count(of.id) > 0 : alive_.engines.count(by.id) > 0;
    expect(status == (lives ? SL_ERROR_THREAD : SL_ERROR_HANDLE), "an error on another thread");
  }

  void step() {
    switch (in_.below(4)) {
      case 0:
        return make();
      case 1:
        return edit();
      case 2:
        return ask();
      default:
        return use_engine();
    }
  }

  void make() {
    switch (in_.below(14)) {
      case 0:
        return create_scene();
      case 1:
        return create_engine();
      case 2:
        return create_culler();
      case 3:
        return add_mesh();
      case 4: {
        sl_material_data data = {sizeof data, in_.byte(), text(), {0.5f, 1.0f, 0.25f * in_.small()}, in_.small()};
        const sl_scene to = scene();
        sl_material made = {0};
        if (in_.one_in(2)) {
          check(sl_material_update(to, {any(made_.materials)}, sized(data)), to);
        } else if (check(sl_material_add(to, sized(data), &made), to) == SL_OK) {
          keep(made_.materials, made.id);
        }
        return;
      }
      case 5:
        return import_file();
      case 6:
        return call_elsewhere();
      case 7: {
        const sl_scene to = scene();
        sl_item made = SL_NO_ITEM;
        check(sl_item_add_mesh(to, node(), mesh(), matrix(), material(), in_.one_in(32) ? nullptr : &made), to);
        return;
      }
      case 8:
      case 9:
      case 10: {
        sl_primitive primitive = {};
        primitive.kind = in_.one_in(16) ? in_.integer() : std::int32_t(in_.below(10));
        for (float& value : primitive.of.parameters) value = in_.small();
        const sl_scene to = scene();
        sl_item made = SL_NO_ITEM;
        check(sl_item_add_primitive(to, node(), in_.one_in(32) ? nullptr : &primitive, matrix(), material(), &made),
              to);
        return;
      }
      default: {
        const sl_scene to = scene();
        sl_node made = {0};
        if (check(sl_node_add(to, node(), text(), matrix(), in_.one_in(32) ? nullptr : &made), to) == SL_OK)
          keep(made_.nodes, made.id);
      }
    }
  }

  void edit() {
    const sl_scene of = scene();
    const sl_node at = node();
    const sl_item which = item();
    switch (in_.below(20)) {
      case 0: {
        if (!in_.one_in(16)) return;
        return check_end(sl_scene_destroy(of), of.id, alive_.scenes);
      }
      case 1: {
        if (!in_.one_in(4)) return;
        const sl_scene other = scene();
        if (check(sl_scene_append(of, at, other), of) == SL_OK) {
          expect(alive_.scenes.count(other.id) > 0, "a live scene to append");
          alive_.scenes.erase(other.id);
        }
        return;
      }
      case 2:
        if (in_.one_in(4)) check(sl_scene_reuse_ids(of, in_.integer()), of);
        check(sl_scene_commit(of), of);
        return;
      case 3:
        if (check(sl_scene_hand_over(of), of) == SL_OK) check(sl_scene_commit(of), of);
        return;
      case 4: {
        sl_node_info info = SL_NODE_INFO_INIT;
        if (check(sl_node_remove(of, at), of) == SL_OK)
          expect(sl_node_get(of, at, &info) == SL_ERROR_HANDLE, "a removed node to be stale");
        return;
      }
      case 5:
        check(sl_node_set_parent(of, at, node()), of);
        return;
      case 6:
        check(sl_node_set_transform(of, at, matrix()), of);
        return;
      case 7:
        check(sl_node_set_visible(of, at, in_.integer()), of);
        return;
      case 8:
        check(sl_node_set_layers(of, at, in_.below(8)), of);
        return;
      case 9:
        check(sl_node_set_material(of, at, material()), of);
        return;
      case 10:
        check(sl_node_set_name(of, at, text()), of);
        return;
      case 11:
        check(sl_node_set_attribute(of, at, text(), text()), of);
        return;
      case 12:
        check(sl_mesh_remove(of, mesh()), of);
        return;
      case 13:
        check(sl_material_remove(of, {any(made_.materials)}), of);
        return;
      case 14: {
        sl_item_info info = SL_ITEM_INFO_INIT;
        if (check(sl_item_remove(of, which), of) == SL_OK)
          expect(sl_item_get(of, which, &info) == SL_ERROR_HANDLE, "a removed item to be gone");
        return;
      }
      case 15:
        check(sl_item_set_placement(of, which, matrix()), of);
        return;
      case 16:
        check(sl_item_set_visible(of, which, in_.integer()), of);
        return;
      case 17:
        check(sl_item_set_material(of, which, material()), of);
        return;
      case 18: {
        const sl_box box = {{in_.number(), in_.number(), in_.number()}, {in_.number(), in_.number(), in_.number()}};
        const sl_box_culler boxes = culler();
        if (in_.one_in(2)) return change_boxes(boxes, box);
        if (in_.one_in(2)) return ask_boxes(boxes, box);
        check(sl_box_culler_update(boxes, in_.below(70), &box), boxes);
        return;
      }
      default:
        if (!in_.one_in(16)) return;
        const sl_box_culler boxes = culler();
        return check_end(sl_box_culler_destroy(boxes), boxes.id, alive_.cullers);
    }
  }

  void ask() {
    const sl_scene of = scene();
    const sl_node at = node();
    std::size_t capacity = 0;
    switch (in_.below(13)) {
      case 0: {
        sl_scene_info info = SL_SCENE_INFO_INIT;
        check(sl_scene_get(of, sized(info)), of);
        return;
      }
      case 1: {
        sl_box box;
        check(sl_scene_bounds(of, at, in_.below(8), in_.one_in(32) ? nullptr : &box), of);
        return;
      }
      case 2: {
        const sl_condition conditions[2] = {{text(), text()}, {text(), text()}};
        sl_node found[kRoom];
        sl_node* to = buffer(found, capacity);
        check(sl_scene_find_nodes(of, at, in_.one_in(16) ? nullptr : conditions, in_.below(3), to, capacity, count()),
              of);
        return;
      }
      case 3: {
        sl_node_info info = SL_NODE_INFO_INIT;
        check(sl_node_get(of, at, sized(info)), of);
        return;
      }
      case 4: {
        double world[16];
        check(sl_node_world_transform(of, at, in_.one_in(32) ? nullptr : world), of);
        return;
      }
      case 5:
        check(sl_node_name(of, at, room_for_text()), of);
        return;
      case 6:
        check(sl_node_path(of, at, room_for_text()), of);
        return;
      case 7:
        check(sl_node_attribute(of, at, in_.below(3), room_for_text(), nullptr), of);
        return;
      case 8: {
        sl_mesh_data data = SL_MESH_DATA_INIT;
        if (check(sl_mesh_get(of, mesh(), sized(data)), of) == SL_OK && data.index_count > 0)
          expect(data.indices[data.index_count - 1] < data.vertex_count, "indices of vertices");
        return;
      }
      case 9: {
        sl_mesh_surface surface = SL_MESH_SURFACE_INIT;
        check(sl_mesh_get_surface(of, mesh(), in_.below(3), sized(surface)), of);
        sl_material_data data = SL_MATERIAL_DATA_INIT;
        check(sl_material_get(of, {any(made_.materials)}, sized(data), room_for_text()), of);
        return;
      }
      case 10: {
        sl_item_info info = SL_ITEM_INFO_INIT;
        check(sl_item_get(of, item(), sized(info)), of);
        return;
      }
      default: {
        std::uint32_t found[kRoom];
        std::uint32_t* to = buffer(found, capacity);
        const sl_box_culler boxes = culler();
        if (in_.one_in(2))
          check(sl_box_culler_visible(boxes, view(), to, capacity, count()), boxes);
        else
          check(sl_box_culler_visible_in(boxes, matrix(), in_.integer(), to, capacity, count()), boxes);
      }
    }
  }

  void use_engine() {
    const sl_engine by = engine();
    std::size_t capacity = 0;
    sl_item items[kRoom];
    const double rectangle[4] = {in_.number(), in_.number(), in_.number() + 16, in_.number() + 16};
    switch (in_.below(36)) {
      case 28: {
        sl_engine_config config = SL_ENGINE_CONFIG_INIT;
        check(sl_engine_get_config(by, sized(config)), by);
        if (in_.one_in(2)) config.culling.culler = draws_ ? in_.integer() : std::int32_t(in_.below(3));
        if (in_.one_in(2)) config.losses.min_projected_area = in_.small(), config.losses.budget_ms = in_.number();
        if (in_.one_in(2))
          config.drawing.looks.depth_shading.strength = in_.small(),
          config.drawing.looks.hatching.strength = in_.small();
        if (in_.one_in(8)) config.drawing.ids = in_.integer(), config.drawing.samples = in_.integer();
        check(sl_engine_configure(by, sized(config)), by);
        return;
      }
      case 29: {
        sl_cull_states states = SL_CULL_STATES_INIT;
        std::uint8_t of_item[kRoom];
        sl_cull_box boxes[kRoom];
        states.of_item = buffer(of_item, states.item_capacity);
        states.boxes = buffer(boxes, states.box_capacity);
        check(sl_engine_cull_states(by, view(), sized(states)), by);
        return;
      }
      case 30: {
        sl_cropped_tile tiles[kRoom];
        sl_cropped_tile* to = buffer(tiles, capacity);
        std::int32_t width = 0, height = 0;
        const std::int32_t wide = in_.one_in(16) ? in_.integer() : std::int32_t(100 * in_.below(8));
        const std::int32_t high = in_.one_in(16) ? in_.integer() : std::int32_t(100 * in_.below(8));
        const sl_status made =
            sl_image_tiles(wide, high, std::int32_t(in_.byte()), in_.integer(), &width, &height, to, capacity, count());
        const sl_image_tile part = made == SL_OK && capacity > 0
                                       ? tiles[0].tile
                                       : sl_image_tile{in_.integer(), in_.integer(), in_.number(), in_.number()};
        check(sl_engine_frame_tile(by, view(), in_.one_in(16) ? nullptr : &part, nullptr), by);
        return;
      }
      case 31: {
        sl_external_target target = SL_EXTERNAL_TARGET_INIT;
        target.width = std::int32_t(in_.below(64)), target.height = std::int32_t(in_.below(64));
        for (sl_item& item : items) item = in_.below(48);
        check(sl_engine_draw_outline(by, view(), in_.one_in(16) ? nullptr : items, in_.below(4), sized(target)), by);
        return;
      }
      case 32: {
        sl_loss_report loss = SL_LOSS_REPORT_INIT;
        sl_controller_info controller = SL_CONTROLLER_INFO_INIT;
        std::int32_t covered = 0;
        std::uint32_t framebuffer = 0;
        check(sl_engine_loss(by, view(), sized(loss)), by);
        check(sl_engine_get_controller(by, sized(controller)), by);
        check(sl_engine_covered(by, in_.one_in(16) ? nullptr : &covered), by);
        check(sl_engine_framebuffer(by, in_.one_in(16) ? nullptr : &framebuffer), by);
        check(sl_engine_renderer(by, room_for_text()), by);
        check(sl_engine_take_gl_errors(by, room_for_text()), by);
        return;
      }
      case 33: {
        sl_pick pick = SL_PICK_INIT;
        std::int32_t complete = 0;
        check(in_.one_in(2) ? sl_engine_prepare_picks(by)
                            : sl_engine_pick_ghosts(by, view(), in_.number(), in_.number(), sized(pick)),
              by);
        check(sl_engine_use_context_for(by, nullptr, nullptr, in_.number(), &complete), by);
        return;
      }
      case 34: {
        sl_item_style style = SL_ITEM_STYLE_INIT;
        std::int32_t there = 0;
        std::size_t count = 0;
        const sl_node nodes[2] = {node(), node()};
        check(sl_engine_get_override(by, item(), in_.one_in(16) ? nullptr : &there, sized(style)), by);
        check(sl_engine_is_hidden(by, item(), &there), by);
        check(sl_engine_overridden_items(by, items, in_.below(4), &count), by);
        check(sl_engine_hidden_items(by, items, in_.below(4), in_.one_in(16) ? nullptr : &count), by);
        check(sl_engine_items_below(by, nodes, in_.below(3), items, in_.below(4), &count), by);
        return;
      }
      case 35: {
        sl_external_target target = SL_EXTERNAL_TARGET_INIT;
        target.width = std::int32_t(in_.below(64)), target.height = std::int32_t(in_.below(64));
        const sl_view* const views[2] = {view(), nullptr};
        const sl_external_target* const targets[2] = {&target, nullptr};
        check(sl_engine_frame_views(by, views, targets, in_.below(3), nullptr), by);
        check(sl_engine_use_image(by, in_.below(4)), by);
        check(sl_engine_forget_image(by, in_.below(4)), by);
        return;
      }
      case 24: {
        sl_item_style style = SL_ITEM_STYLE_INIT;
        style.use_colour = in_.integer(), style.alpha = in_.small(), style.colour[0] = in_.small();
        style.outline = in_.one_in(4), style.ghost = in_.one_in(4);
        for (sl_item& item : items) item = in_.below(48);
        check(sl_engine_set_override(by, in_.one_in(16) ? nullptr : items, in_.below(kRoom), sized(style)), by);
        return;
      }
      case 25:
        for (sl_item& item : items) item = in_.below(48);
        check(sl_engine_clear_override(by, in_.one_in(4) ? nullptr : items, in_.below(4)), by);
        return;
      case 26:
        for (sl_item& item : items) item = in_.below(48);
        check(sl_engine_set_hidden(by, in_.one_in(16) ? nullptr : items, in_.below(4), in_.integer()), by);
        return;
      case 27: {
        const sl_node nodes[2] = {node(), node()};
        check(in_.one_in(2) ? sl_engine_isolate(by, nodes, in_.below(3)) : sl_engine_show_all(by), by);
        return;
      }
      case 0: {
        if (!in_.one_in(16)) return;
        return check_end(sl_engine_destroy(by), by.id, alive_.engines);
      }
      case 1:
      case 2:
      case 3:
      case 4: {
        sl_frame_report report = SL_FRAME_REPORT_INIT;
        const sl_view drawn = *required(view());
        check(sl_engine_frame(by, &drawn, in_.one_in(4) ? view() : nullptr, sized(report)), by);
        return;
      }
      case 5: {
        sl_external_target target = SL_EXTERNAL_TARGET_INIT;
        target.framebuffer = in_.below(2), target.x = in_.integer(), target.y = in_.integer();
        target.width = std::int32_t(in_.below(64)), target.height = std::int32_t(in_.below(64));
        target.near_depth = in_.number(), target.far_depth = in_.number();
        check(sl_engine_frame_into(by, view(), sized(target), nullptr), by);
        return;
      }
      case 6:
        check(sl_engine_commit(by), by);
        return;
      case 7:
        check(sl_engine_rebuild(by), by);
        return;
      case 8: {
        const std::int32_t culler = draws_ ? in_.integer() : std::int32_t(in_.below(3));
        check(sl_engine_set_culler(by, culler), by);
        return;
      }
      case 9: {
        const auto width = std::int32_t(in_.below(64)), height = std::int32_t(in_.below(64));
        check(sl_engine_resize(by, width, height), by);
        return;
      }
      case 10: {
        sl_late_report report = SL_LATE_REPORT_INIT;
        check(sl_engine_late_report(by, sized(report)), by);
        return;
      }
      case 11:
        check(in_.one_in(3)   ? sl_engine_paused(by)
              : in_.one_in(2) ? sl_engine_finish(by)
                              : sl_engine_finish_levels(by),
              by);
        return;
      case 12: {
        sl_engine_info info = SL_ENGINE_INFO_INIT;
        check(sl_engine_get(by, sized(info)), by);
        return;
      }
      case 13:
        check(sl_engine_explain(by, room_for_text()), by);
        return;
      case 14:
      case 15: {
        sl_item* to = buffer(items, capacity);
        check(sl_engine_visible(by, to, capacity, count()), by);
        return;
      }
      case 16:
        check(in_.one_in(2) ? sl_engine_drop_context(by) : sl_engine_abandon_context(by), by);
        return;
      case 17:
        check(sl_engine_use_context(by, nullptr, nullptr), by);
        return;
      case 18: {
        std::vector<std::uint8_t> rgb(3 * 64 * 64);
        std::vector<std::uint32_t> ids(64 * 64);
        std::vector<float> metres(64 * 64);
        check(sl_engine_read_colour(by, rgb.data(), in_.one_in(16) ? 0 : rgb.size()), by);
        check(sl_engine_read_ids(by, ids.data(), ids.size()), by);
        check(sl_engine_read_depth(by, view(), metres.data(), metres.size()), by);
        return;
      }
      case 19: {
        sl_pick pick = SL_PICK_INIT;
        check(sl_engine_pick(by, view(), in_.number() + 16, in_.number() + 16, sized(pick)), by);
        return;
      }
      case 20: {
        sl_pick pick = SL_PICK_INIT;
        sl_ray ray = SL_RAY_INIT;
        for (int i = 0; i < 3; ++i) ray.origin[i] = in_.number(), ray.direction[i] = in_.number();
        if (in_.one_in(4)) ray.t_min = in_.number(), ray.t_max = in_.number();
        ray.hit_ghosts = in_.one_in(2), ray.leave_out_cuts = in_.one_in(2);
        ray.section_count = in_.one_in(16) ? in_.byte() : in_.below(3);
        ray.section_mode = in_.one_in(16) ? in_.integer() : std::int32_t(in_.below(2));
        for (sl_plane& plane : ray.sections) plane = {{in_.number(), in_.number(), in_.number()}, in_.number()};
        check(sl_engine_pick_ray(by, sized(ray), sized(pick)), by);
        return;
      }
      case 21: {
        sl_item* to = buffer(items, capacity);
        check(sl_engine_items_in(by, view(), rectangle, in_.integer(), to, capacity, count()), by);
        return;
      }
      case 22: {
        sl_plane planes[9];
        for (sl_plane& plane : planes) plane = {{in_.number(), in_.number(), in_.number()}, in_.number()};
        sl_item* to = buffer(items, capacity);
        check(sl_engine_items_in_planes(by, planes, in_.below(10), in_.integer(), in_.below(8), to, capacity, count()),
              by);
        return;
      }
      default: {
        sl_visible_item visible[kRoom];
        sl_visible_item* to = buffer(visible, capacity);
        check(sl_engine_visible_items_in(by, view(), rectangle, in_.integer() % 4, to, capacity, count()), by);
      }
    }
  }

  const sl_view* required(const sl_view* from) { return from ? from : &view_; }

  struct Handles {
    std::vector<std::uint64_t> scenes, engines, cullers, nodes, meshes, materials;
  };
  struct Alive {
    std::set<std::uint64_t> scenes, engines, cullers;
  };
  Input in_;
  const bool draws_;
  Handles made_;  // dead ones as well
  std::vector<std::uint64_t> made_all_;
  Alive alive_;
  sl_scene importing_ = {0};
  double matrix_[16] = {};
  sl_view view_ = SL_VIEW_INIT;
  char characters_[kRoom] = {};
  sl_text text_ = {nullptr, 0, 0};
  std::size_t count_ = 0;
  std::string wrong_;
};

}  // namespace

std::string make_random_calls(const std::uint8_t* data, std::size_t size, bool draws) {
  return Sequence(data, size, draws).run();
}

}  // namespace sightline::tests
