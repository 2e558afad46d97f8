// Every function of the header, called with null, stale, huge and empty arguments: it returns a status and ends
// nothing. everything.inc, made from the header, lists functions and structs, so that new ones are called, too. What a
// caller must not do is left out: arrays shorter than a count that may be true, and pointers to nothing.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "c_scene.h"
#include "sightline/sightline.h"

namespace sightline::tests::hostile_calls_test {
namespace {

constexpr int kRandomCalls = 200, kCallsPerWorld = 24;
constexpr std::uint32_t kSeed = 60;
constexpr std::size_t kBytes = 1 << 16;  // of every buffer: more than any call here may use

template <class T>
bool initialise(T&) {
  return false;
}
#define FUNCTION(name)
#define STRUCT(name, init)    \
  bool initialise(name& of) { \
    of = init;                \
    return true;              \
  }
#include "everything.inc"
#undef STRUCT
#undef FUNCTION

/// A scene with an engine, and objects that were destroyed.
struct World {
  sl_scene scene, gone_scene;
  sl_engine engine, gone_engine;
  sl_node node, gone_node;
  sl_mesh mesh, gone_mesh;
  sl_material material, gone_material;
  sl_box_culler culler, gone_culler;
  sl_occluder_raster raster, gone_raster;

  World() {
    const float corners[] = {0, 0, 0, 1, 0, 0, 0, 0, 1};
    const std::uint32_t indices[] = {0, 1, 2};
    sl_mesh_data data = SL_MESH_DATA_INIT;
    data.vertex_count = 3, data.index_count = 3;
    data.positions = corners, data.indices = indices;
    sl_material_data paint = SL_MATERIAL_DATA_INIT;
    sl_engine_config config = SL_ENGINE_CONFIG_INIT;
    config.width = config.height = 16;
    const sl_box boxes[2] = {{{0, 0, 0}, {1, 1, 1}}, {{2, 2, 2}, {3, 3, 3}}};
    sl_scene_info info = SL_SCENE_INFO_INIT;
    sl_item item = 0;
    good(sl_scene_create(&scene));
    good(sl_scene_get(scene, &info));
    good(sl_node_add(scene, info.root, "node", nullptr, &node));
    good(sl_node_add(scene, info.root, "gone", nullptr, &gone_node));
    for (sl_mesh* made : {&mesh, &gone_mesh}) good(sl_mesh_add(scene, &data, made));
    for (sl_material* made : {&material, &gone_material}) good(sl_material_add(scene, &paint, made));
    good(sl_item_add_mesh(scene, node, mesh, nullptr, material, &item));
    good(sl_node_remove(scene, gone_node));
    good(sl_mesh_remove(scene, gone_mesh));
    good(sl_material_remove(scene, gone_material));
    for (sl_engine* made : {&engine, &gone_engine}) good(sl_engine_create(scene, &config, made));
    good(sl_engine_destroy(gone_engine));
    good(sl_scene_create(&gone_scene));
    good(sl_scene_destroy(gone_scene));
    for (sl_box_culler* made : {&culler, &gone_culler}) good(sl_box_culler_create(boxes, 2, made));
    good(sl_box_culler_destroy(gone_culler));
    for (sl_occluder_raster* made : {&raster, &gone_raster}) good(sl_occluder_raster_create(made));
    good(sl_occluder_raster_destroy(gone_raster));
  }
  World(const World&) = delete;
  World& operator=(const World&) = delete;
  ~World() {
    (void)sl_engine_destroy(engine);
    (void)sl_scene_destroy(scene);
    (void)sl_box_culler_destroy(culler);
    (void)sl_occluder_raster_destroy(raster);
  }
  static void good(sl_status status) { EXPECT_EQ(status, SL_OK) << sl_last_error(); }
};

/// Values of the arguments of one function. Each kind of argument has a list, the harmless value first.
class Arguments {
 public:
  Arguments(World& world, bool sizeless) : world_(world), sizeless_(sizeless) {}

  template <class T>
  std::vector<T> values() {
    if constexpr (std::is_pointer_v<T>)
      return pointers<T>();
    else if constexpr (std::is_floating_point_v<T>)
      return {T(1), T(0), T(-1), std::numeric_limits<T>::quiet_NaN(), std::numeric_limits<T>::infinity(), T(1e300)};
    else if constexpr (std::is_same_v<T, std::size_t>)
      return {0, 1, kMost, kMost / 2 + 1, kMost / 3, kMost / 16, kMost / 64 + 2};
    else if constexpr (std::is_signed_v<T>)
      return sizeless_ ? std::vector<T>{1, 0, -1, 7, std::numeric_limits<T>::min()}
                       : std::vector<T>{1, 0, -1, 7, std::numeric_limits<T>::max(), std::numeric_limits<T>::min()};
    else if constexpr (std::is_unsigned_v<T>)
      return {0, 1, 77, std::numeric_limits<T>::max()};
    else
      return handles<T>();
  }

 private:
  static constexpr std::size_t kMost = std::numeric_limits<std::size_t>::max();

  template <class T>
  std::vector<T> handles() const {
    std::vector<T> all;
    const auto add = [&](auto handle) {
      if constexpr (std::is_same_v<T, decltype(handle)>) all.push_back(handle);
    };
    add(world_.scene), add(world_.gone_scene), add(world_.engine), add(world_.gone_engine);
    add(world_.node), add(world_.gone_node), add(world_.mesh), add(world_.gone_mesh);
    add(world_.material), add(world_.gone_material), add(world_.culler), add(world_.gone_culler);
    add(world_.raster), add(world_.gone_raster);
    for (const std::uint64_t any : {std::uint64_t(0), std::uint64_t(-1), world_.scene.id, world_.node.id ^ 1u})
      all.push_back({any});
    return all;
  }

  template <class T>
  std::vector<T> pointers() {
    using Value = std::remove_const_t<std::remove_pointer_t<T>>;
    if constexpr (std::is_function_v<std::remove_pointer_t<T>>) {
      return functions<T>();
    } else if constexpr (std::is_void_v<Value>) {
      return {nullptr};
    } else if constexpr (std::is_same_v<T, const char*>) {
      static const std::string kLong(5000, 'x');
      return {"x.rvm", "", nullptr, "\xff\xfe/\x01", kLong.c_str()};
    } else if constexpr (std::is_pointer_v<Value>) {
      std::vector<T> lists{nullptr};
      for (const Value element : pointers<Value>()) lists.push_back(array_of(element));
      std::swap(lists.front(), lists[1]);
      return lists;
    } else {
      const std::vector<Value*> all = buffers<Value>();
      return {all.begin(), all.end()};
    }
  }
  template <class T>
  static std::vector<T> functions() {
    if constexpr (std::is_invocable_r_v<std::int32_t, T, double, void*>)
      return {nullptr, [](double share, void*) { return std::int32_t(share < 0.5); }};
    else if constexpr (std::is_invocable_r_v<sl_proc, T, const char*, void*>)
      return {nullptr, [](const char*, void*) { return sl_proc(nullptr); }};
    else
      return {nullptr};
  }

  /// Structs as their initialisers make them, with sizes that none has, all zero, and where no pointer or flag is in
  /// them full of odd numbers.
  template <class Value>
  std::vector<Value*> buffers() {
    std::vector<Value*> all{buffer<Value>()};
    Value made{};
    if constexpr (std::is_floating_point_v<Value>)
      for (const double odd : {1e300, -1e300, std::nan(""), 1e-320}) all.push_back(array_of(Value(odd)));
    if constexpr (std::is_same_v<Value, double>) all.front() = identity();
    if constexpr (requires { made.size; }) {
      EXPECT_TRUE(initialise(made)) << "a struct without an initialiser";
      small(made);
      std::memcpy(static_cast<void*>(all.front()), &made, sizeof made);
      for (const std::uint32_t size : {0u, 1u, 4096u, 0xffffffffu}) {
        made.size = size;
        Value* sized = buffer<Value>();
        std::memcpy(static_cast<void*>(sized), &made, sizeof made);
        all.push_back(sized);
      }
    } else if constexpr (!std::is_same_v<Value, sl_text> && !std::is_same_v<Value, sl_condition>) {
      Value* odd = buffer<Value>();
      std::memset(static_cast<void*>(odd), 0x7f, kBytes);
      all.push_back(odd);
    } else if constexpr (std::is_same_v<Value, sl_text>) {
      all.push_back(array_of(sl_text{buffer<char>(), kBytes, 0}));
      all.push_back(array_of(sl_text{nullptr, kMost, 0}));
    }
    all.push_back(nullptr);
    return all;
  }
  static void small(sl_engine_config& config) { config.width = config.height = 16; }
  static void small(sl_external_target& target) { target.width = target.height = 16; }
  static void small(sl_view& view) {
    const sl_pose pose = {{0, -5, 0}, {0, 0, 0}, {0, 0, 1}};
    World::good(sl_view_perspective(&pose, 0.8, 1.0, 0.1, 100.0, &view));
  }
  template <class T>
  static void small(T&) {}

  template <class Value>
  Value* buffer() {
    return reinterpret_cast<Value*>(memory_.emplace_back(kBytes / sizeof(double)).data());
  }
  template <class Value>
  Value* array_of(const Value& value) {
    Value* array = buffer<Value>();
    std::fill_n(array, kBytes / sizeof(Value), value);
    return array;
  }
  double* identity() {
    double* matrix = buffer<double>();
    for (int i = 0; i < 16; i += 5) matrix[i] = 1.0;
    return matrix;
  }

  World& world_;
  const bool sizeless_;  // it takes an image without its size in bytes
  std::vector<std::vector<double>> memory_;
};

/// Calls the function with one argument after the other changed, and with any of them at random.
class Attack {
 public:
  template <class... A>
  void run(const char* name, sl_status (*function)(A...)) {
    sizeless_ = std::string_view(name) == "sl_write_png" || std::string_view(name) == "sl_box_culler_visible_in_depth";
    call(name, function, std::vector<std::size_t>(sizeof...(A), 0));
    for (std::size_t changed = 0; changed < sizeof...(A); ++changed)
      for (std::size_t value = 1; value < 12; ++value) {
        std::vector<std::size_t> picks(sizeof...(A), 0);
        picks[changed] = value;
        call(name, function, picks);
      }
    for (int i = 0; i < kRandomCalls; ++i) {
      std::vector<std::size_t> picks;
      for (std::size_t argument = 0; argument < sizeof...(A); ++argument) picks.push_back(random_() % 16);
      call(name, function, picks);
    }
  }

 private:
  template <class... A>
  void call(const char* name, sl_status (*function)(A...), const std::vector<std::size_t>& picks) {
    if (calls_++ % kCallsPerWorld == 0) world_.reset(), world_ = std::make_unique<World>();
    Arguments arguments(*world_, sizeless_);
    std::size_t at = 0;
    const auto pick = [&]<class T>(std::type_identity<T>) {
      const std::vector<T> all = arguments.values<T>();
      return all[picks[at++] % all.size()];
    };
    const std::tuple<A...> chosen{pick(std::type_identity<A>())...};
    const sl_status status = std::apply(function, chosen);
    ASSERT_TRUE(status >= SL_OK && status <= SL_ERROR_UNSUPPORTED) << name << " of seed " << kSeed;
    ASSERT_TRUE(status == SL_OK || *sl_last_error() != '\0') << name;
  }

  std::mt19937 random_{kSeed};
  std::unique_ptr<World> world_;
  std::size_t calls_ = 0;
  bool sizeless_ = false;
};

/// A call that ends the process is named by the last line that was printed.
TEST(CapiHostileCalls, EveryFunctionReturnsAStatus) {
  const std::filesystem::path before = std::filesystem::current_path();
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "sightline_hostile_calls";
  std::filesystem::create_directories(folder);
  std::filesystem::current_path(folder);  // for files of relative names
  int functions = 0;
  Attack attack;
#define STRUCT(name, init)
#define FUNCTION(name)     \
  std::puts(#name);        \
  std::fflush(stdout);     \
  attack.run(#name, name); \
  ++functions;
#include "everything.inc"
#undef STRUCT
#undef FUNCTION
  EXPECT_GE(functions, 129);
  std::filesystem::current_path(before);
  std::filesystem::remove_all(folder);
}

TEST(CapiHostileCalls, CountsThatNoArrayHasAreRefused) {
  World world;
  const sl_condition condition = {"a", "b"};
  sl_node node{};
  sl_item item = 0;
  const char* path = "x.rvm";
  const sl_view view = SL_VIEW_INIT;
  const sl_view* views = &view;
  const sl_external_target target = SL_EXTERNAL_TARGET_INIT;
  const sl_external_target* targets = &target;
  const float corner[3] = {};
  const std::uint32_t index = 0;
  sl_mesh_data mesh = SL_MESH_DATA_INIT;
  mesh.positions = corner, mesh.indices = &index, mesh.vertex_count = 1, mesh.index_count = std::uint64_t(-1);
  std::size_t count = 0;
  for (const std::size_t huge : {SIZE_MAX, SIZE_MAX / 2, SIZE_MAX / 16, std::size_t(1) << 40}) {
    const auto refused = [](sl_status status) {
      EXPECT_TRUE(status == SL_ERROR_ARGUMENT || status == SL_ERROR_UNSUPPORTED) << status;
    };
    refused(sl_scene_find_nodes(world.scene, world.node, &condition, huge, &node, 1, &count));
    refused(sl_import(world.scene, world.node, &path, huge, nullptr, nullptr, nullptr));
    refused(sl_engine_frame_views(world.engine, &views, &targets, huge, nullptr));
    refused(sl_engine_set_hidden(world.engine, &item, huge, 1));
    refused(sl_engine_isolate(world.engine, &world.node, huge));
    refused(sl_engine_items_below(world.engine, &world.node, huge, &item, 1, &count));
    sl_box_culler made{};
    const sl_box box{};
    refused(sl_box_culler_create(&box, huge, &made));
    refused(sl_box_culler_update_many(world.culler, &index, &box, huge));
    refused(sl_occluder_raster_add_largest(world.raster, &box, huge, 1, nullptr));
  }
  sl_view seen = SL_VIEW_INIT;
  const sl_pose pose = {{0, -5, 0}, {0, 0, 0}, {0, 0, 1}};
  ASSERT_EQ(sl_view_perspective(&pose, 0.8, 1.0, 0.1, 100.0, &seen), SL_OK);
  ASSERT_EQ(sl_occluder_raster_begin(world.raster, &seen, 8, 8), SL_OK);
  EXPECT_EQ(sl_occluder_raster_add_mesh(world.raster, &mesh, nullptr), SL_ERROR_ARGUMENT);
  sl_mesh added{};
  EXPECT_EQ(sl_mesh_add(world.scene, &mesh, &added), SL_ERROR_ARGUMENT);
}

}  // namespace
}  // namespace sightline::tests::hostile_calls_test
