/* capi: Sightline for C and for everything that can call C. Nothing but translation: each function names the C++ one
 * that it calls where that documents more.
 *
 *   sl_scene scene;
 *   sl_engine engine;
 *   if (sl_scene_create(&scene) != SL_OK) return fail(sl_last_error());
 *   ...
 *
 * Errors. Every function that can fail returns sl_status; SL_OK is 0. sl_last_error() then says what went wrong, in one
 * line. A message for each thread, and not an error object for each call: a caller who does not look has nothing to
 * free, and bindings read it at once. A failed call changes nothing and leaves its results as they were, but for
 * SL_ERROR_MEMORY.
 *
 * Handles. A handle is a number in a struct of its own, so that compilers tell scenes from engines. All zero is the
 * null handle. Numbers are never used again, so a handle that is null, destroyed, or of another kind gives
 * SL_ERROR_HANDLE. Nodes, meshes, materials and items belong to one scene. In another scene theirs is a handle like any
 * other: it is stale or names something there.
 *
 * Ownership. What sl_..._create() makes is the caller's until sl_..._destroy(). Engines keep their scene alive: after
 * sl_scene_destroy() it is out of reach, and freed with its last engine. So both may be destroyed in any order. All
 * arguments are copied; the library keeps no pointer but those of callbacks, as said there. Buffers for results are the
 * caller's: a function writes as many values as fit, and says how many there are. Pass a null buffer of capacity 0 to
 * ask for the number alone.
 *
 * Threads. A scene and its engines belong to one thread: the one that made the scene, or that took it after
 * sl_scene_hand_over(). On any other thread their functions, sl_..._destroy() among them, give SL_ERROR_THREAD.
 * Different scenes may be used on different threads at once. All other functions may be called from any threads at any
 * time: those of views, box cullers, occluder rasters and paged engines, sl_scene_create() and those that have no
 * handle. During an import, calls on its scene give SL_ERROR_BUSY.
 *
 * Versions. Structs that may grow begin with their size. Initialise them with their SL_..._INIT, which has the default
 * of each field; results need only `size`. Programs made for an older version then work with a newer library, and the
 * other way round where the program leaves the new fields zero. Structs without a size, and enumerators, do not change.
 *
 * Conventions are those of sightline/core/conventions.h: metres, z up, right-handed, radians. Matrices are sixteen
 * numbers in columns, as OpenGL takes them. Texts are UTF-8 and end with a zero. Flags are int32_t: 0 or not 0.
 *
 * What cannot be checked remains the caller's: pointers must be valid or null, arrays as long as the counts beside them
 * say, and a GL context given to an engine must be current in its calls. A count that no array can have is refused
 * (SL_ERROR_ARGUMENT): of conditions, views and paths more than 65536. No C++ exception leaves a function, nor may one
 * leave a callback. */
#ifndef SIGHTLINE_CAPI_SIGHTLINE_H
#define SIGHTLINE_CAPI_SIGHTLINE_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define SL_API __attribute__((visibility("default")))
#else
#define SL_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* --- versions and errors ---------------------------------------------------------------------------------------- */

#define SL_VERSION_MAJOR 0
#define SL_VERSION_MINOR 2
#define SL_VERSION_PATCH 0
#define SL_VERSION (SL_VERSION_MAJOR * 1000000 + SL_VERSION_MINOR * 1000 + SL_VERSION_PATCH)

/* SL_VERSION of the library that runs. */
SL_API int32_t sl_version(void);

/* What the library that runs was built with. Functions of the rest give SL_ERROR_UNSUPPORTED. */
enum {
  SL_FEATURE_DRAWING = 1,   /* engines that draw or cull on the GPU */
  SL_FEATURE_PICKING = 2,   /* sl_engine_pick() and sl_engine_visible_items_in() */
  SL_FEATURE_IMPORTING = 4, /* sl_import() and sl_view_read() */
  SL_FEATURE_PNG = 8        /* sl_write_png() */
};
SL_API uint32_t sl_features(void);

typedef int32_t sl_status;
enum {
  SL_OK = 0,
  SL_ERROR_HANDLE = 1,     /* null, stale, or of another kind */
  SL_ERROR_THREAD = 2,     /* the object belongs to another thread */
  SL_ERROR_ARGUMENT = 3,   /* null where that is not allowed, out of range, a struct without its size */
  SL_ERROR_BUSY = 4,       /* in use: what must be done first is in the message */
  SL_ERROR_FAILED = 5,     /* a file, the scene's content or GL: the message says what */
  SL_ERROR_CANCELLED = 6,  /* by the progress callback */
  SL_ERROR_MEMORY = 7,     /* what the call was changing may be half changed: it then accepts nothing but destruction */
  SL_ERROR_UNSUPPORTED = 8 /* this build of the library lacks it: sl_features() */
};

/* Why the last failed call of this thread failed; empty when none has. Valid until the next failed call of this thread.
 * At most 1023 bytes. */
SL_API const char* sl_last_error(void);

/* --- handles ---------------------------------------------------------------------------------------------------- */

typedef struct sl_scene {
  uint64_t id;
} sl_scene;
typedef struct sl_node {
  uint64_t id;
} sl_node;
typedef struct sl_mesh {
  uint64_t id;
} sl_mesh;
typedef struct sl_material {
  uint64_t id;
} sl_material;
typedef struct sl_engine {
  uint64_t id;
} sl_engine;
typedef struct sl_box_culler {
  uint64_t id;
} sl_box_culler;
typedef struct sl_occluder_raster {
  uint64_t id;
} sl_occluder_raster;
typedef struct sl_paged_engine {
  uint64_t id;
} sl_paged_engine;
/* Items are numbered in the order of their insertion into their scene; numbers are not used again. Images of ids and
 * visible sets hold them. */
typedef uint32_t sl_item;
#define SL_NO_ITEM 0xffffffffu

/* --- small values ----------------------------------------------------------------------------------------------- */

/* A buffer for text. Up to capacity - 1 bytes and a zero are written; length becomes that of the whole text. */
typedef struct sl_text {
  char* data;
  size_t capacity;
  size_t length;
} sl_text;

typedef struct sl_box {
  double min[3], max[3];
} sl_box; /* closed; empty when min > max in any axis */

/* dot(normal, p) + offset >= 0 is kept. */
typedef struct sl_plane {
  double normal[3], offset;
} sl_plane;

/* Where a camera stands and looks. */
typedef struct sl_pose {
  double eye[3], target[3], up[3];
} sl_pose;

/* Layer bits. An item is shown when its layers share a bit with the view's. */
#define SL_LAYER_MODEL 1u
#define SL_LAYER_OBSTRUCTION 2u
#define SL_LAYER_INSULATION 4u
#define SL_DEFAULT_LAYERS 0xfffffff9u /* all but obstruction and insulation volumes */

/* --- scenes: sightline/core/scene.h ------------------------------------------------------------------------------ */

typedef struct sl_scene_info {
  uint32_t size;
  sl_node root;
  uint64_t nodes, items; /* alive, the root included */
  uint64_t item_slots;   /* items are below this */
} sl_scene_info;
#define SL_SCENE_INFO_INIT \
  { sizeof(sl_scene_info), {0}, 0, 0, 0 }

SL_API sl_status sl_scene_create(sl_scene* scene);
SL_API sl_status sl_scene_destroy(sl_scene scene);
/* Gives the scene up: the next thread that uses it owns it. For loading on a worker. Fails with SL_ERROR_BUSY once an
 * engine uses the scene. */
SL_API sl_status sl_scene_hand_over(sl_scene scene);
/* Moves everything below the root of `other` to below `parent`, and destroys `other`. Its handles become stale. Items
 * get new numbers, in their order, or after sl_scene_reuse_ids() first those that are free. Both must belong to this
 * thread; `other` must never have been committed, and its root hold no items. The nodes become the last children of
 * `parent`. */
SL_API sl_status sl_scene_append(sl_scene scene, sl_node parent, sl_scene other);
/* Publishes all edits. All or nothing: fails where numbers are not finite, and names the node; the edits then stay
 * pending. An application with an engine calls sl_engine_commit(). */
SL_API sl_status sl_scene_commit(sl_scene scene);
SL_API sl_status sl_scene_get(sl_scene scene, sl_scene_info* info);
/* Whether what is added from now on may get ids of items that were removed after this call: for programs that add and
 * remove for days, which forget the ids that they remove. Off at first. Scene::reuse_ids() in scene.h says more. */
SL_API sl_status sl_scene_reuse_ids(sl_scene scene, int32_t reuse);
/* World bounds of what is visible below a node on any of `layers`; an empty box when there is nothing. */
SL_API sl_status sl_scene_bounds(sl_scene scene, sl_node top, uint32_t layers, sl_box* bounds);

/* What names nodes. Without a key (null or empty) `text` is looked for in steps, the first of which that finds a node
 * decides: a path (as sl_node_path() has it, or its end from any node on), a name, the value of any attribute or with
 * "KEY=TEXT" of one (key "Name": the node's name, too), whole words of names and values. A text with `*` (any
 * characters) or `?` (one), or a regular expression after "re:", is a pattern instead of words. With a key: `text` is
 * the value of that attribute, or a pattern of it; an empty one any value. Case counts first, then upper and lower case
 * of ASCII are alike. Slashes that names begin with may be missing. core/find_nodes.h of C++ says more. */
typedef struct sl_condition {
  const char *key, *text;
} sl_condition;
/* Nodes below `top` (itself included) that fulfil all conditions, by the earliest step that finds any, parents first.
 * None are no error; a regular expression that is none is. */
SL_API sl_status sl_scene_find_nodes(sl_scene scene, sl_node top, const sl_condition* conditions,
                                     size_t condition_count, sl_node* nodes, size_t capacity, size_t* count);

/* --- nodes ------------------------------------------------------------------------------------------------------ */
/* Transforms are parent_from_node; null is the identity. Their last row must be 0 0 0 1. */

typedef struct sl_node_info {
  uint32_t size;
  uint32_t layers;                           /* as set: 0 inherits */
  sl_node parent, first_child, next_sibling; /* null where there is none */
  sl_material material;                      /* as set: null inherits */
  double transform[16];
  uint64_t attributes; /* number of them */
  sl_item first_item;
  int32_t visible;
} sl_node_info;
#define SL_NODE_INFO_INIT \
  { sizeof(sl_node_info), 0, {0}, {0}, {0}, {0}, {0}, 0, 0, 0 }

SL_API sl_status sl_node_add(sl_scene scene, sl_node parent, const char* name, const double transform[16],
                             sl_node* node);
/* Removes it with its subtree and all their items. Not the root. */
SL_API sl_status sl_node_remove(sl_scene scene, sl_node node);
/* Fails when `parent` lies below `node`. */
SL_API sl_status sl_node_set_parent(sl_scene scene, sl_node node, sl_node parent);
SL_API sl_status sl_node_set_transform(sl_scene scene, sl_node node, const double transform[16]);
SL_API sl_status sl_node_set_visible(sl_scene scene, sl_node node, int32_t visible);
SL_API sl_status sl_node_set_layers(sl_scene scene, sl_node node, uint32_t layers);
/* For items of the subtree that have none of their own; null inherits. */
SL_API sl_status sl_node_set_material(sl_scene scene, sl_node node, sl_material material);
SL_API sl_status sl_node_set_name(sl_scene scene, sl_node node, const char* name);
SL_API sl_status sl_node_set_attribute(sl_scene scene, sl_node node, const char* key, const char* value);

SL_API sl_status sl_node_get(sl_scene scene, sl_node node, sl_node_info* info);
SL_API sl_status sl_node_world_transform(sl_scene scene, sl_node node, double world_from_node[16]);
SL_API sl_status sl_node_name(sl_scene scene, sl_node node, sl_text* name);
/* Names from below the root to the node, joined by "/"; unnamed nodes are "#k", k their place among their siblings. */
SL_API sl_status sl_node_path(sl_scene scene, sl_node node, sl_text* path);
/* Attribute `index` in the order set. Either text may be null. */
SL_API sl_status sl_node_attribute(sl_scene scene, sl_node node, size_t index, sl_text* key, sl_text* value);

/* --- meshes and materials --------------------------------------------------------------------------------------- */

typedef struct sl_mesh_data {
  uint32_t size;
  uint32_t vertex_count;
  const char* name;        /* may be null */
  const float* positions;  /* three a vertex */
  const float* normals;    /* as many, or null */
  const uint32_t* indices; /* three a triangle, counter-clockwise from outside */
  uint64_t index_count;
} sl_mesh_data;
#define SL_MESH_DATA_INIT \
  { sizeof(sl_mesh_data), 0, NULL, NULL, NULL, NULL, 0 }

/* Fails on an index that is not below vertex_count and on a position that is not finite, and names it. */
SL_API sl_status sl_mesh_add(sl_scene scene, const sl_mesh_data* data, sl_mesh* mesh);
/* Points into the scene: valid until the mesh is removed or the scene destroyed, since meshes never change. The name is
 * left out (null). */
SL_API sl_status sl_mesh_get(sl_scene scene, sl_mesh mesh, sl_mesh_data* data);
enum {
  SL_SURFACE_OTHER = 0,
  SL_SURFACE_PLANE = 1,
  SL_SURFACE_CYLINDER = 2,
  SL_SURFACE_CONE = 3,
  SL_SURFACE_SPHERE = 4,
  SL_SURFACE_TORUS = 5
};
typedef struct sl_mesh_surface {
  uint32_t size;
  int32_t kind;              /* SL_SURFACE_...; the rest says nothing of others */
  double origin[3], axis[3]; /* in the mesh's coordinates; the axis is a unit vector: a plane's normal */
  double radius;             /* of a torus: of the circle of the tube's centre; of a cone: at the origin */
  double tube_radius;        /* of a torus */
  double slope;              /* of a cone: tangent of its half angle, by which the radius grows along the axis */
} sl_mesh_surface;
#define SL_MESH_SURFACE_INIT \
  { sizeof(sl_mesh_surface), SL_SURFACE_OTHER, {0}, {0}, 0.0, 0.0, 0.0 }

/* The surface that the mesh's file (STEP, IGES, BREP) states for the face of a triangle, such as that of a pick. */
SL_API sl_status sl_mesh_get_surface(sl_scene scene, sl_mesh mesh, uint32_t triangle, sl_mesh_surface* surface);
/* Fails with SL_ERROR_BUSY while an item uses it. Looks at every item. */
SL_API sl_status sl_mesh_remove(sl_scene scene, sl_mesh mesh);

typedef struct sl_material_data {
  uint32_t size;
  uint32_t code;    /* the source file's own number */
  const char* name; /* may be null */
  float colour[3];  /* sRGB, 0 to 1 */
  float alpha;      /* 1 opaque, 0 invisible */
} sl_material_data;
#define SL_MATERIAL_DATA_INIT \
  { sizeof(sl_material_data), 0, NULL, {0.7f, 0.7f, 0.7f}, 1.0f }

SL_API sl_status sl_material_add(sl_scene scene, const sl_material_data* data, sl_material* material);
SL_API sl_status sl_material_update(sl_scene scene, sl_material material, const sl_material_data* data);
/* `name` may be null; data->name is left out (null). */
SL_API sl_status sl_material_get(sl_scene scene, sl_material material, sl_material_data* data, sl_text* name);
/* Nodes and items that have it inherit one from then on. Looks at all of them. */
SL_API sl_status sl_material_remove(sl_scene scene, sl_material material);

/* --- items ------------------------------------------------------------------------------------------------------ */

typedef int32_t sl_kind;
enum {
  SL_PYRAMID = 0,
  SL_BOX = 1,
  SL_RECTANGULAR_TORUS = 2,
  SL_CIRCULAR_TORUS = 3,
  SL_ELLIPTICAL_DISH = 4,
  SL_SPHERICAL_DISH = 5,
  SL_SNOUT = 6,
  SL_CYLINDER = 7,
  SL_SPHERE = 8,
  SL_LINE = 9,
  SL_FACET_GROUP = 10, /* a mesh that an importer made of polygons */
  SL_MESH = 11
};
#define SL_KIND_COUNT 12

/* One of the first ten kinds with its parameters: sightline/core/primitive.h says what they mean. */
typedef struct sl_primitive {
  sl_kind kind;
  union {
    float parameters[9]; /* in the order of these: */
    struct {
      float bottom_x, bottom_y, top_x, top_y, offset_x, offset_y, height;
    } pyramid;
    struct {
      float size_x, size_y, size_z;
    } box;
    struct {
      float inner_radius, outer_radius, height, angle;
    } rectangular_torus;
    struct {
      float major_radius, tube_radius, angle;
    } circular_torus;
    struct {
      float base_radius, height;
    } elliptical_dish;
    struct {
      float base_radius, height;
    } spherical_dish;
    struct {
      float bottom_radius, top_radius, height, offset_x, offset_y;
      float bottom_shear_x, bottom_shear_y, top_shear_x, top_shear_y;
    } snout;
    struct {
      float radius, height;
    } cylinder;
    struct {
      float diameter;
    } sphere;
    struct {
      float from, to;
    } line;
  } of;
} sl_primitive;

typedef struct sl_item_info {
  uint32_t size;
  sl_kind kind;
  sl_node node;
  sl_mesh mesh;           /* of a facet group or mesh; else null */
  sl_material material;   /* as set: null is the node's */
  double placement[16];   /* node_from_item */
  sl_primitive primitive; /* its kind is that of the item; for meshes without parameters */
  sl_item next_item;      /* of the same node */
  int32_t visible;
} sl_item_info;
#define SL_ITEM_INFO_INIT \
  { sizeof(sl_item_info), 0, {0}, {0}, {0}, {0}, {0, {{0}}}, 0, 0 }

/* `placement` is node_from_item, null the identity; its last row must be 0 0 0 1. A null material is the node's. */
SL_API sl_status sl_item_add_primitive(sl_scene scene, sl_node node, const sl_primitive* primitive,
                                       const double placement[16], sl_material material, sl_item* item);
SL_API sl_status sl_item_add_mesh(sl_scene scene, sl_node node, sl_mesh mesh, const double placement[16],
                                  sl_material material, sl_item* item);
SL_API sl_status sl_item_remove(sl_scene scene, sl_item item);
SL_API sl_status sl_item_set_placement(sl_scene scene, sl_item item, const double placement[16]);
SL_API sl_status sl_item_set_visible(sl_scene scene, sl_item item, int32_t visible);
SL_API sl_status sl_item_set_material(sl_scene scene, sl_item item, sl_material material);
SL_API sl_status sl_item_get(sl_scene scene, sl_item item, sl_item_info* info);

/* --- import: sightline/importers/import.h ------------------------------------------------------------------------ */

/* SL_UP_AUTOMATIC: what a comment at the begin of an OBJ or PLY file says; else y, with a warning, where the meshes of
 * such a file or of an STL file stand on a base in y and on none in z; else z. */
enum { SL_UP_Y = 0, SL_UP_Z = 1, SL_UP_AUTOMATIC = 2 };
enum { SL_COPIES_APART = 0, SL_COPIES_EXACT = 1, SL_COPIES_SIMILAR = 2 };
/* Why a solid of a mesh, or a part of one, stayed triangles. */
enum {
  SL_REFUSED_OPEN = 0,         /* not closed */
  SL_REFUSED_CAVITY = 1,       /* inside out, unlike the mesh as a whole */
  SL_REFUSED_NO_STRUCTURE = 2, /* neither rings of vertices nor faces of a box or pyramid */
  SL_REFUSED_OFF_SURFACE = 3,  /* rings, but of no primitive within the tolerance */
  SL_REFUSED_BROKEN = 4        /* triangles, not solids, with two equal corners or one that is not finite */
};
#define SL_REFUSED_COUNT 5

typedef struct sl_import_options {
  uint32_t size;
  int32_t lenient;        /* import what can be read of damaged files */
  double metres_per_unit; /* for formats that state no unit */
  int32_t up;             /* SL_UP_...: for the same formats */
  int32_t copies;         /* SL_COPIES_...: which meshes of a file are kept only once */
  int32_t threads;        /* for several files; 0: one for each processor */
  /* Called on the importing thread with the share that is done, 0 to 1. Returning 0 cancels. May be null. */
  int32_t (*progress)(double share, void* user);
  /* Called on the importing thread before sl_import() returns, for each problem that did not stop it. May be null. */
  void (*warning)(const char* file, uint64_t offset, const char* message, void* user);
  void* user; /* passed to both */
  /* Where scene caches are kept (docs/guide/scene-cache.md), made when absent; null or empty: none. An import of the
   * same unchanged files with the same options then reads the cache instead, with the same result. What goes wrong with
   * it is a warning, never an error. */
  const char* cache_folder;
  /* Whether meshes become primitives where they are the triangles of some (docs/guide/recognition.md). */
  int32_t recognise;
  /* How far vertices may lie from a recognised surface, in metres; 0: what each mesh's own tessellation tells. */
  double recognise_tolerance;
  /* Whether scene caches hold levels of detail (docs/guide/levels-of-detail.md), which then come with the meshes. They
   * are built where a cache has none. Has an effect only with cache_folder. */
  int32_t cached_levels;
  int32_t reserved; /* 0 */
  /* Radians, 0 to pi: meshes without normals (OBJ, PLY, STL, VTK) get those of smooth surfaces, broken at edges that
   * are bent by more than this. 0: they are shown facet by facet. */
  double crease_angle;
  /* For exact surfaces (STEP, IGES, BREP) of no primitive: how far triangles may lie from them, in metres; 0: 0.05 % of
   * each part's diagonal. */
  double chord_tolerance;
  double chord_angle; /* radians, above 0 to pi: the largest angle between neighbouring facets of a curve */
  /* Whether the same formats are read in this process. Open CASCADE, which reads them, may crash, never end or take all
   * memory where a file is hostile or damaged; so a process of its own does it otherwise. */
  int32_t in_process;
  int32_t reserved_2; /* 0 */
} sl_import_options;
#define SL_IMPORT_OPTIONS_INIT                                                                                      \
  {                                                                                                                 \
    sizeof(sl_import_options), 0, 1.0, SL_UP_AUTOMATIC, SL_COPIES_SIMILAR, 0, NULL, NULL, NULL, NULL, 0, 0.0, 0, 0, \
        0.0, 0.0, 0.34906585039886592, 0, 0                                                                         \
  }

typedef struct sl_import_report {
  uint32_t size;
  uint32_t node_count;           /* one for each model file */
  uint64_t items[SL_KIND_COUNT]; /* by kind, as found in the files */
  uint64_t degenerate;           /* without volume, length or area */
  uint64_t shared_meshes;        /* items whose mesh another item brought */
  uint64_t attributed;           /* groups that an attribute file gave attributes to */
  uint64_t bytes;                /* read */
  uint64_t warnings;
  double sharing_error;   /* metres: no vertex of those meshes lies farther from where the file has it */
  double metres_per_unit; /* of the last file */
  int32_t from_cache;     /* a scene cache was read instead of the files */
  /* What sl_import_options.recognise did. Meshes count once, however many items share them. */
  uint64_t recognised[SL_KIND_COUNT]; /* items of primitives made, by kind */
  uint64_t meshes_examined;
  uint64_t triangles_before, triangles_after;   /* of those meshes */
  uint64_t mesh_bytes_before, mesh_bytes_after; /* of vertices, normals, indices; of parameters afterwards */
  double largest_deviation; /* metres between triangles and surfaces that replace them, both ways, in the scene */
  uint64_t refused[SL_REFUSED_COUNT]; /* solids by SL_REFUSED_..., those recognised in part included */
  /* What became of exact surfaces: STEP, IGES, BREP. Parts count once, however often they are used. */
  uint64_t parts, instances;
  uint64_t analytic_solids;       /* that became primitives */
  uint64_t meshed_bodies;         /* other solids, shells and loose faces */
  uint64_t surface_triangles;     /* of these */
  uint64_t failed_faces;          /* that could not be meshed */
  uint64_t curves, annotations;   /* not read */
  double largest_chord_tolerance; /* of any part, metres */
  double surface_deviation;       /* metres: the largest distance found between triangles and surfaces */
  double analytic_deviation;      /* metres: no primitive lies farther from its solid's surfaces */
} sl_import_report;
#define SL_IMPORT_REPORT_INIT                                                                                        \
  {                                                                                                                  \
    sizeof(sl_import_report), 0, {0}, 0, 0, 0, 0, 0, 0.0, 0.0, 0, {0}, 0, 0, 0, 0, 0, 0.0, {0}, 0, 0, 0, 0, 0, 0, 0, \
        0, 0.0, 0.0, 0.0                                                                                             \
  }

/* Reads files into new children of `parent`, one for each model file. All or nothing. `options` may be null, and so may
 * `nodes` (room for path_count) and `report`. */
SL_API sl_status sl_import(sl_scene scene, sl_node parent, const char* const* paths, size_t path_count,
                           const sl_import_options* options, sl_node* nodes, sl_import_report* report);
/* ".rvm .txt .ply": what this library reads, by the ends of file names. Empty when it reads nothing. */
SL_API const char* sl_import_extensions(void);

/* --- views: sightline/core/view.h -------------------------------------------------------------------------------- */

typedef int32_t sl_clip_depth;
enum {
  SL_DEPTH_REVERSED_ZERO_TO_ONE = 0, /* near at 1, far at 0 */
  SL_DEPTH_MINUS_ONE_TO_ONE = 1,     /* classic OpenGL */
  SL_DEPTH_ZERO_TO_ONE = 2           /* near at 0, far at 1: Vulkan, Direct3D, WebGPU */
};
enum { SL_SECTIONS_INTERSECTION = 0, SL_SECTIONS_UNION = 1 };
#define SL_MAX_SECTIONS 8

/* A camera: a value without a lifetime. Sections and layers may be set after a function has made the rest. */
typedef struct sl_view {
  uint32_t size;
  uint32_t layers;
  double eye_from_world[16], clip_from_eye[16];
  sl_clip_depth clip_depth;
  int32_t section_mode;   /* SL_SECTIONS_...: whether all planes keep a point or any */
  uint64_t section_count; /* up to SL_MAX_SECTIONS */
  sl_plane sections[SL_MAX_SECTIONS];
} sl_view;
#define SL_VIEW_INIT                                         \
  {                                                          \
    sizeof(sl_view), SL_DEFAULT_LAYERS, {0}, {0}, 0, 0, 0, { \
      { {0}, 0 }                                             \
    }                                                        \
  }

/* Each sets all of `view` but its size: all of the model's layers and no sections. `fovy` is in radians; `z_far` may be
 * infinite (HUGE_VAL) in perspective. */
SL_API sl_status sl_view_perspective(const sl_pose* pose, double fovy, double aspect, double z_near, double z_far,
                                     sl_view* view);
SL_API sl_status sl_view_orthographic(const sl_pose* pose, double height, double aspect, double z_near, double z_far,
                                      sl_view* view);
/* left, right, bottom, top: on the near plane. */
SL_API sl_status sl_view_asymmetric(const sl_pose* pose, double left, double right, double bottom, double top,
                                    double z_near, double z_far, sl_view* view);
/* The box fills the image, seen along `direction` (null: from above and the south-west). */
SL_API sl_status sl_view_fit(const sl_box* bounds, const double direction[3], double fovy, double aspect,
                             sl_view* view);
/* From an application's own matrices. With a null eye_from_world the other one is projection * view: such a view can
 * cull but not be drawn. Fails where the projection's depth falls with distance and `depth` says that it grows, or the
 * other way round. */
SL_API sl_status sl_view_from_matrices(const double eye_from_world[16], const double clip_from_eye[16],
                                       sl_clip_depth depth, sl_view* view);
/* From a JSON file: sightline/importers/view_json.h. */
SL_API sl_status sl_view_read(const char* path, double aspect, sl_view* view);

/* --- culling without a scene: sightline/culling/box_culler.h ----------------------------------------------------- */
/* May be used from any threads at once; changes of boxes wait for those that cull. */

SL_API sl_status sl_box_culler_create(const sl_box* boxes, size_t box_count, sl_box_culler* culler);
SL_API sl_status sl_box_culler_destroy(sl_box_culler culler);
/* Indices of the boxes in the view volume, in no order; the first `capacity` of them are written. */
SL_API sl_status sl_box_culler_visible(sl_box_culler culler, const sl_view* view, uint32_t* indices, size_t capacity,
                                       size_t* count);
/* The same for projection * view. */
SL_API sl_status sl_box_culler_visible_in(sl_box_culler culler, const double clip_from_world[16], sl_clip_depth depth,
                                          uint32_t* indices, size_t capacity, size_t* count);
SL_API sl_status sl_box_culler_update(sl_box_culler culler, uint32_t index, const sl_box* box);
/* Replaces box indices[i] by boxes[i] for each i below `count`, several times faster than one by one. Of an index that
 * is repeated the last box counts. */
SL_API sl_status sl_box_culler_update_many(sl_box_culler culler, const uint32_t* indices, const sl_box* boxes,
                                           size_t count);
/* Replaces all boxes; `box_count` must be that of sl_box_culler_create(). */
SL_API sl_status sl_box_culler_refit(sl_box_culler culler, const sl_box* boxes, size_t box_count);

/* --- occlusion without a scene: sightline/culling/occlusion/occluder_raster.h ---------------------------------- */
/* A depth image of chosen occluders, made by the CPU alone. Those must be solid, opaque and drawn. Reuse a raster from
 * frame to frame; calls on one wait for each other. */

SL_API sl_status sl_occluder_raster_create(sl_occluder_raster* raster);
SL_API sl_status sl_occluder_raster_destroy(sl_occluder_raster raster);
/* Empties the image, for occluders of this view in an image of width x height pixels, 1 to 16384 each. */
SL_API sl_status sl_occluder_raster_begin(sl_occluder_raster raster, const sl_view* view, int32_t width,
                                          int32_t height);
/* Solid boxes in the world: of these the `most` that look largest from the eye. `added` (may be null): how many of them
 * meet the view volume. */
SL_API sl_status sl_occluder_raster_add_largest(sl_occluder_raster raster, const sl_box* boxes, size_t box_count,
                                                size_t most, size_t* added);
/* The cube -1 to 1 in a placement. */
SL_API sl_status sl_occluder_raster_add_cube(sl_occluder_raster raster, const double world_from_cube[16]);
/* The cylinder of radius 1 about z, from -1 to 1, as its inscribed prism of 3 to 16 sides. */
SL_API sl_status sl_occluder_raster_add_cylinder(sl_occluder_raster raster, const double world_from_cylinder[16],
                                                 int32_t sides);
/* Triangles, seen from both sides. `mesh`: its positions and indices alone are read. */
SL_API sl_status sl_occluder_raster_add_mesh(sl_occluder_raster raster, const sl_mesh_data* mesh,
                                             const double world_from_mesh[16]);
/* The image: metres along the viewing direction, row by row from the bottom up, infinity where nothing is. `capacity`
 * is in values, of which width * height are needed. */
SL_API sl_status sl_occluder_raster_read(sl_occluder_raster raster, float* metres, size_t capacity);

/* As sl_box_culler_visible(), without boxes that are hidden behind the raster's occluders, of the same view, or that
 * cover none of its pixel centres. The view must know its eye: one made from a combined matrix does not. */
SL_API sl_status sl_box_culler_visible_behind(sl_box_culler culler, const sl_view* view, sl_occluder_raster raster,
                                              uint32_t* indices, size_t capacity, size_t* count);
/* The same for an application's own depth of this view, as sl_occluder_raster_read() has it. `metres` has no size of
 * its own: it must hold width * height values, and all of them are read. */
SL_API sl_status sl_box_culler_visible_in_depth(sl_box_culler culler, const sl_view* view, const float* metres,
                                                int32_t width, int32_t height, uint32_t* indices, size_t capacity,
                                                size_t* count);

/* --- engines: sightline/engine/engine.h -------------------------------------------------------------------------- */

typedef int32_t sl_culler;
enum { SL_CULLER_AUTOMATIC = 0, SL_CULLER_LINEAR = 1, SL_CULLER_CPU = 2, SL_CULLER_GPU = 3, SL_CULLER_HYBRID = 4 };
enum { SL_OCCLUSION_OFF = 0, SL_OCCLUSION_ON = 1, SL_OCCLUSION_AUTOMATIC = 2 };
enum {
  SL_CONTEXT_AUTOMATIC = 0,
  SL_CONTEXT_EGL = 1,
  SL_CONTEXT_EGL_SURFACELESS = 2,
  SL_CONTEXT_EGL_DEVICE = 3,
  SL_CONTEXT_OSMESA = 4
};
enum { SL_GL_STATE_RESTORE = 0, SL_GL_STATE_LEAVE = 1 };
enum { SL_CONTRIBUTION_DROP = 0, SL_CONTRIBUTION_POINTS = 1, SL_CONTRIBUTION_STOCHASTIC = 2 };
enum { SL_TRANSPARENCY_DITHER = 0, SL_TRANSPARENCY_BLENDED = 1 };
enum { SL_LIGHTING_HEAD_LIGHT = 0, SL_LIGHTING_STUDIO = 1, SL_LIGHTING_SUN = 2 };
/* How the GPU culls: measured once for each context, or as named. */
enum { SL_GPU_VARIANT_MEASURED = 0, SL_GPU_VARIANT_GEOMETRY = 1, SL_GPU_VARIANT_COMPUTE = 2 };

typedef void (*sl_proc)(void);
/* Finds a GL function by its full name ("glEnable"); null when unknown. */
typedef sl_proc (*sl_get_proc)(const char* name, void* user);

/* When a hybrid takes which culler: ControllerConfig of sightline/culling/hybrid/controller.h. Thresholds are finite
 * and not below 0. */
typedef struct sl_controller_config {
  uint32_t size;
  uint32_t dwell_frames;
  double least_gpu_cull_ms, margin, dwell_margin, probe_share, probe_cost, presumed_gpu_excess;
  uint32_t first_probes, probe_interval, silent_frames;
  int32_t reserved; /* 0 */
} sl_controller_config;
#define SL_CONTROLLER_CONFIG_INIT \
  { sizeof(sl_controller_config), 8, 0.01, 0.01, 0.20, 0.005, 0.004, 0.0, 2, 200, 16, 0 }

typedef struct sl_engine_config {
  uint32_t size;
  sl_culler culler;
  int32_t draw; /* 0: no GL at all, unless the culler needs it */
  int32_t width, height;
  int32_t ids;               /* an image of item ids beside colour and depth */
  int32_t sample_test;       /* leave out of drawing what covers no sample */
  int32_t occlusion;         /* SL_OCCLUSION_...: leave out of drawing what others hide */
  int32_t contribution_mode; /* SL_CONTRIBUTION_... */
  float min_projected_area;  /* pixels; leave out of drawing what covers fewer; 0: nothing is lost */
  double budget_ms;          /* a frame may take; 0: any time */
  int32_t samples;           /* per pixel */
  int32_t use_culled_colour;
  float culled_colour[3]; /* sRGB; of what the tests leave out in frames with a cull_view */
  float rebuild_share;    /* disorder by edits that starts a new scene version in the background; 0: never */
  /* The application's GL context, which must be current now and in all later calls on the engine. Null: the engine
   * makes an offscreen context. Called in sl_engine_create() alone. */
  sl_get_proc get_proc;
  void* get_proc_user;
  int32_t gl_state;          /* SL_GL_STATE_...: what calls leave of what the application has in GL */
  int32_t context_platform;  /* SL_CONTEXT_...: of the offscreen context */
  const char* program_cache; /* folder that keeps linked programs; null: the user's cache folder; "": none */
  int32_t transparency;      /* SL_TRANSPARENCY_...: how transparent items are drawn */
  float outline_colour[3];   /* sRGB; of sl_item_style.outline and sl_engine_draw_outline() */
  /* Shading and lines by the depth of the image: 0 to 1, darkness of corners and of what lies behind edges, and of
   * lines along edges. 0: none. */
  float depth_shading, edge_lines;
  /* Lines on what section planes cut: 0 to 1, their darkness, 0: none; and their least distance, 2 pixels or more. */
  float hatching_strength, hatching_spacing;
  /* Draws, culls and finds part part_index of part_count parts of the scene alone: for several engines, in several
   * processes, that share an image. */
  int32_t part_index, part_count;
  int32_t gl_debug;                       /* collect driver messages: sl_engine_take_gl_errors() */
  int32_t context_later;                  /* no context until sl_engine_use_context(); not with get_proc */
  int32_t gpu_variant;                    /* SL_GPU_VARIANT_... */
  int32_t lighting;                       /* SL_LIGHTING_... */
  const sl_controller_config* controller; /* of SL_CULLER_HYBRID; null: its defaults */
  /* Called in sl_engine_create() alone, now and then, with the share that is done, 0 to 1. Returning 0 before 1
   * cancels. May be null. */
  int32_t (*progress)(double share, void* user);
  void* progress_user;
  double lod_error; /* pixels that a mesh may be drawn elsewhere by coarser levels of detail; 0: none */
  double sun[3];    /* direction to the light of SL_LIGHTING_SUN, in the world; not 0 */
  float background_bottom[3], background_top[3]; /* sRGB, 0 to 1; the colour changes evenly in between */
} sl_engine_config;
#define SL_ENGINE_CONFIG_INIT                                                                                        \
  {                                                                                                                  \
    sizeof(sl_engine_config), SL_CULLER_AUTOMATIC, 0, 1280, 720, 0, 1, SL_OCCLUSION_AUTOMATIC, SL_CONTRIBUTION_DROP, \
        0.0f, 0.0, 1, 0, {0.0f, 0.0f, 0.0f}, 0.03f, NULL, NULL, SL_GL_STATE_RESTORE, SL_CONTEXT_AUTOMATIC, NULL,     \
        SL_TRANSPARENCY_DITHER, {1.0f, 0.5f, 0.0f}, 0.0f, 0.0f, 0.0f, 6.0f, 0, 1, 0, 0, SL_GPU_VARIANT_MEASURED,     \
        SL_LIGHTING_HEAD_LIGHT, NULL, NULL, NULL, 0.0, {0.0, 0.0, 1.0}, {0.86f, 0.88f, 0.91f}, {                     \
      0.86f, 0.88f, 0.91f                                                                                            \
    }                                                                                                                \
  }

/* -1 where a count is not known. Times are milliseconds of wall clock. FrameReport in engine.h says more. */
typedef struct sl_frame_report {
  uint32_t size;
  sl_culler culler; /* that culled: linear, CPU or GPU */
  uint64_t frame;   /* frames before this one */
  double cull_ms, draw_ms, wait_ms, frame_ms;
  int64_t visible, tested;        /* items in the view volume; boxes tested */
  int64_t sampled, items_drawn;   /* of the visible, that may cover a sample; drawn */
  int64_t below_min_area, splats; /* below min_projected_area; drawn as splats */
  int64_t pending;                /* items that the budget did not suffice for */
  int32_t drawn;
  int32_t hybrid_state; /* -1 without a hybrid; else ControllerState of culling/hybrid/frame_sample.h */
  int64_t triangles;    /* drawn, of meshes alone */
} sl_frame_report;
#define SL_FRAME_REPORT_INIT \
  { sizeof(sl_frame_report), 0, 0, 0.0, 0.0, 0.0, 0.0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0 }

/* A part of a framebuffer of the application's: sightline/gl/external_target.h. */
typedef struct sl_external_target {
  uint32_t size;
  uint32_t framebuffer;         /* GL's name; 0: the window's */
  int32_t x, y, width, height;  /* from its lower left corner */
  double near_depth, far_depth; /* what its depth buffer holds at the near and at the far plane */
  int32_t clear_colour;         /* fill the part with the background first */
  int32_t clear_depth;          /* fill its depth buffer with far_depth first */
  int32_t linear_colour;        /* write linear light instead of sRGB values */
  int32_t reserved;             /* 0 */
} sl_external_target;
#define SL_EXTERNAL_TARGET_INIT \
  { sizeof(sl_external_target), 0, 0, 0, 0, 0, 0.0, 1.0, 0, 0, 0, 0 }

/* What the GPU culler found in an earlier frame. */
typedef struct sl_late_report {
  uint32_t size;
  int32_t there; /* 0: nothing new has arrived, and the rest says nothing */
  uint64_t frame;
  int64_t visible, items_drawn;
  double gpu_cull_ms;
} sl_late_report;
#define SL_LATE_REPORT_INIT \
  { sizeof(sl_late_report), 0, 0, 0, 0, 0.0 }

typedef struct sl_engine_info {
  uint32_t size;
  sl_culler culler;        /* as planned: never automatic */
  int32_t rebuilding;      /* a new scene version is being made in the background */
  int32_t preparing_picks; /* the ray tracer is being made in the background, and a pick would wait for it */
  uint64_t scene_bytes, snapshot_bytes, hierarchy_bytes, gpu_bytes, tracer_bytes;
  uint64_t scratch_bytes; /* buffers that all threads of the process keep from call to call */
  uint64_t levels_bytes;  /* clusters and levels of detail of meshes, in main memory */
} sl_engine_info;
#define SL_ENGINE_INFO_INIT \
  { sizeof(sl_engine_info), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0 }

/* What contribution, budget and levels of detail cost an image. LossReport in engine.h says more. */
typedef struct sl_loss_report {
  uint32_t size;
  int32_t reserved; /* 0 */
  int64_t items;    /* left out, that may cover a sample and that nothing in the image is known to hide */
  double pixels;    /* that these are expected to cover, at most all */
  double lod_error; /* pixels by which meshes may be drawn elsewhere, proved */
  int64_t triangles, full_triangles; /* drawn of meshes; that the same items have in full */
  double coarser_share;              /* of the items with a mesh that are drawn, those by coarser levels */
} sl_loss_report;
#define SL_LOSS_REPORT_INIT \
  { sizeof(sl_loss_report), 0, 0, 0.0, 0.0, 0, 0, 0.0 }

/* What a hybrid's controller has done so far. */
typedef struct sl_controller_info {
  uint32_t size;
  int32_t there;             /* 0: the engine has no hybrid, and the rest says nothing */
  int32_t state;             /* ControllerState of culling/hybrid/frame_sample.h */
  int32_t reserved;          /* 0 */
  uint64_t frames, switches; /* frames so far; changes of the path, without probes */
  uint64_t probes;           /* frames on the other path that only measured it */
} sl_controller_info;
#define SL_CONTROLLER_INFO_INIT \
  { sizeof(sl_controller_info), 0, 0, 0, 0, 0, 0 }

/* What culling makes of an item, or of a node of the hierarchy: sightline/culling/cull_states.h. */
enum { SL_CULL_INSIDE = 0, SL_CULL_INTERSECTING = 1, SL_CULL_OUTSIDE = 2, SL_CULL_OCCLUDED = 3, SL_CULL_TOO_SMALL = 4 };
#define SL_CULL_STATE_COUNT 5
typedef struct sl_cull_box {
  sl_box box; /* in the world */
  int32_t state;
  uint32_t items; /* of that state in it; above 0 */
} sl_cull_box;
typedef struct sl_cull_states {
  uint32_t size;
  uint32_t reserved;                   /* 0 */
  uint64_t items[SL_CULL_STATE_COUNT]; /* by state */
  /* The caller's buffers: a state for each item below sl_scene_info.item_slots, SL_CULL_OUTSIDE where there is none;
   * and boxes of nodes and items. The counts become those of all. */
  uint8_t* of_item;
  size_t item_capacity, item_count;
  sl_cull_box* boxes;
  size_t box_capacity, box_count;
} sl_cull_states;
#define SL_CULL_STATES_INIT \
  { sizeof(sl_cull_states), 0, {0}, NULL, 0, 0, NULL, 0, 0 }

/* A tile of an image, of the size that the engine draws in: sightline/engine/image_tiles.h. */
typedef struct sl_image_tile {
  int32_t width, height; /* of the whole image, pixels */
  double x, y;           /* of the tile's upper left corner in it */
} sl_image_tile;
/* A tile, and the rectangle x0 <= x < x1, y0 <= y < y1 of the whole image that is taken from it. */
typedef struct sl_cropped_tile {
  sl_image_tile tile;
  int32_t x0, y0, x1, y1;
} sl_cropped_tile;

/* Commits the scene and builds what the engine needs. `config` may be null. */
SL_API sl_status sl_engine_create(sl_scene scene, const sl_engine_config* config, sl_engine* engine);
/* Frees everything that it has in the application's context, which must be current, unless sl_engine_abandon_context()
 * was called. */
SL_API sl_status sl_engine_destroy(sl_engine engine);
/* Culls and draws. `cull_view` (null: `view`) is the view whose volume is culled. `report` may be null. */
SL_API sl_status sl_engine_frame(sl_engine engine, const sl_view* view, const sl_view* cull_view,
                                 sl_frame_report* report);
/* The same into a framebuffer of the application's context, with the depth test, in the order of GL's commands. The
 * engine's image gets the target's size. */
SL_API sl_status sl_engine_frame_into(sl_engine engine, const sl_view* view, const sl_external_target* target,
                                      sl_frame_report* report);
/* Draws a line around items over a framebuffer that shows the last frame's image, `view` and the target's size being
 * those of that frame: for what is under a cursor. Takes the time of these items and of two passes over the image. */
SL_API sl_status sl_engine_draw_outline(sl_engine engine, const sl_view* view, const sl_item* items, size_t item_count,
                                        const sl_external_target* target);
/* Draws a tile of an image of `whole` that may be larger than any framebuffer. `report` may be null. */
SL_API sl_status sl_engine_frame_tile(sl_engine engine, const sl_view* whole, const sl_image_tile* tile,
                                      sl_frame_report* report);
/* Tiles of at most `largest_side` pixels a side that join without seams, all of tile_width x tile_height pixels.
 * Fails unless largest_side is at least 64 and twice the margins of 8 and `more_margin` pixels more. Sizes are at most
 * 262144 pixels. */
SL_API sl_status sl_image_tiles(int32_t width, int32_t height, int32_t largest_side, int32_t more_margin,
                                int32_t* tile_width, int32_t* tile_height, sl_cropped_tile* tiles, size_t capacity,
                                size_t* count);
/* What the last frame has left out, `view` being the one that it drew. Waits for the GPU. */
SL_API sl_status sl_engine_loss(sl_engine engine, const sl_view* view, sl_loss_report* report);
/* What culling makes of each item in the view. Draws for that, so that the last frame's image is gone. */
SL_API sl_status sl_engine_cull_states(sl_engine engine, const sl_view* view, sl_cull_states* states);
/* The same for several views at one time, such as the two eyes of a headset: view i goes into target i and has image
 * i of sl_engine_use_image(); a budget is for all of them together. `reports` may be null. */
SL_API sl_status sl_engine_frame_views(sl_engine engine, const sl_view* const* views,
                                       const sl_external_target* const* targets, size_t count,
                                       sl_frame_report* const* reports);
/* Shows another one of the engine's images from now on; each has a number of the application's, at first 0. One for
 * each view keeps what the engine learns from frame to frame: its size, a budget's unfinished image, what was large
 * or seen in the last frame. A new one has the size of the one before. */
SL_API sl_status sl_engine_use_image(sl_engine engine, uint32_t number);
/* Frees what the engine has for an image. Fails for the one in use. */
SL_API sl_status sl_engine_forget_image(sl_engine engine, uint32_t number);
SL_API sl_status sl_engine_late_report(sl_engine engine, sl_late_report* report);
/* Commits the scene's edits; frames show none before. */
SL_API sl_status sl_engine_commit(sl_engine engine);
/* The same in portions: works for about `seconds`, and says whether all edits are followed. */
SL_API sl_status sl_engine_commit_for(sl_engine engine, double seconds, int32_t* complete);
/* Makes a new scene version at once. */
SL_API sl_status sl_engine_rebuild(sl_engine engine);
SL_API sl_status sl_engine_set_culler(sl_engine engine, sl_culler culler);
/* The settings as they are now, in the size of the last sl_engine_resize(). Pointers among them are null. `controller`
 * may be null. */
SL_API sl_status sl_engine_get_config(sl_engine engine, sl_engine_config* config, sl_controller_config* controller);
/* Uses other settings from the next frame on: culler, controller (null: as it is), sample_test, occlusion,
 * min_projected_area, contribution_mode, budget_ms, lod_error, culled_colour, outline_colour, depth shading and
 * hatching. get_proc, program_cache and progress are not looked at; all others must be as they are. */
SL_API sl_status sl_engine_configure(sl_engine engine, const sl_engine_config* config);
/* In pixels, 1 to 65536. */
SL_API sl_status sl_engine_resize(sl_engine engine, int32_t width, int32_t height);
/* Tells that the application drew nothing for a while. */
SL_API sl_status sl_engine_paused(sl_engine engine);
/* Waits until everything submitted is drawn. */
SL_API sl_status sl_engine_finish(sl_engine engine);
/* Waits until the levels of detail that lod_error asks for are built and uploaded. */
SL_API sl_status sl_engine_finish_levels(sl_engine engine);
SL_API sl_status sl_engine_get(sl_engine engine, sl_engine_info* info);
SL_API sl_status sl_engine_get_controller(sl_engine engine, sl_controller_info* info);
/* What the engine uses and what it leaves out, with reasons, a line each; the last line names the GL renderer. */
SL_API sl_status sl_engine_explain(sl_engine engine, sl_text* text);
/* As GL names it; empty while there is no context. */
SL_API sl_status sl_engine_renderer(sl_engine engine, sl_text* text);
/* What the driver has complained of, a line each: see sl_engine_config.gl_debug. Lines are told once, but all of them
 * again where the text had no room for all. */
SL_API sl_status sl_engine_take_gl_errors(sl_engine engine, sl_text* text);

/* Items in the view volume of the last frame, in no order, for renderers of one's own. None where the GPU culled. Fails
 * with SL_ERROR_BUSY when a new scene version has landed since: ask before the next sl_engine_commit(). */
SL_API sl_status sl_engine_visible(sl_engine engine, sl_item* items, size_t capacity, size_t* count);

/* Frees what the engine has in its context, which must be current. Frames are then culled and not drawn. */
SL_API sl_status sl_engine_drop_context(sl_engine engine);
/* The same for a context that is gone with all that was in it: calls no GL. */
SL_API sl_status sl_engine_abandon_context(sl_engine engine);
/* Makes everything anew in the application's context that is current now. The former one must have been dropped or
 * abandoned: else SL_ERROR_BUSY. */
SL_API sl_status sl_engine_use_context(sl_engine engine, sl_get_proc get_proc, void* user);
/* The same in portions: works for about `seconds`, and says whether everything is made. While it is not, call it again
 * with the same context current; get_proc is then not looked at. Dropping or abandoning the context ends that, too. */
SL_API sl_status sl_engine_use_context_for(sl_engine engine, sl_get_proc get_proc, void* user, double seconds,
                                           int32_t* complete);

/* The image of the last frame, rows from top to bottom; waits for the GPU. `capacity` is in values, of which
 * width * height (colour: three times as many) are needed. */
SL_API sl_status sl_engine_read_colour(sl_engine engine, uint8_t* rgb, size_t capacity);
/* Item + 1; 0 where there is none. */
SL_API sl_status sl_engine_read_ids(sl_engine engine, uint32_t* ids, size_t capacity);
/* Metres along the axis of `view`, which is the one that was drawn; infinity where there is nothing. */
SL_API sl_status sl_engine_read_depth(sl_engine engine, const sl_view* view, float* metres, size_t capacity);
/* Whether any pixel of the last frame's image shows anything but the background. */
SL_API sl_status sl_engine_covered(sl_engine engine, int32_t* covered);
/* GL's name of the framebuffer with that image, in the context that the engine draws with. */
SL_API sl_status sl_engine_framebuffer(sl_engine engine, uint32_t* framebuffer);
/* Rows from top to bottom, three bytes a pixel. `rgb` has no size of its own: it must hold 3 * width * height bytes,
 * and all of them are read. Replaces the file only when complete. */
SL_API sl_status sl_write_png(const char* path, int32_t width, int32_t height, const uint8_t* rgb);

/* --- picks and regions ------------------------------------------------------------------------------------------- */

typedef struct sl_pick {
  uint32_t size;
  sl_item item;               /* SL_NO_ITEM: nothing was hit, and the rest says nothing */
  sl_node node;               /* that held it at the engine's last commit; the scene may have removed it since */
  double t;                   /* along the ray; metres, where its direction has unit length */
  double point[3], normal[3]; /* in the world; the normal points out of the solid */
  uint32_t triangle;          /* of a mesh; 0xffffffff for solids and cuts */
  int32_t face;               /* raytrace::Face of sightline/raytrace/tracer.h */
} sl_pick;
#define SL_PICK_INIT \
  { sizeof(sl_pick), SL_NO_ITEM, {0}, 0.0, {0}, {0}, 0, 0 }

typedef struct sl_ray {
  uint32_t size;
  uint32_t layers;
  double origin[3], direction[3]; /* below 1e150 */
  double t_min, t_max;
  int32_t hit_ghosts;     /* 0: rays go through items whose style is ghost */
  int32_t leave_out_cuts; /* not 0: what section planes cut is no face, and rays see the insides */
  int32_t section_mode;   /* SL_SECTIONS_... */
  uint32_t section_count; /* up to SL_MAX_SECTIONS */
  sl_plane sections[SL_MAX_SECTIONS];
} sl_ray;
#define SL_RAY_INIT                                                                                              \
  {                                                                                                              \
    sizeof(sl_ray), SL_DEFAULT_LAYERS, {0}, {0.0, 1.0, 0.0}, 0.0, HUGE_VAL, 0, 0, SL_SECTIONS_INTERSECTION, 0, { \
      { {0}, 0 }                                                                                                 \
    }                                                                                                            \
  }

enum { SL_REGION_CROSSING = 0, SL_REGION_WHOLLY = 1 };

typedef struct sl_visible_item {
  sl_item item;
  uint32_t reserved; /* 0 */
  uint64_t samples;  /* that show it */
} sl_visible_item;

/* What the view shows at a point of the image, in pixels from its upper left corner. */
SL_API sl_status sl_engine_pick(sl_engine engine, const sl_view* view, double x, double y, sl_pick* pick);
/* The same, and items whose style is ghost are hit as all others. */
SL_API sl_status sl_engine_pick_ghosts(sl_engine engine, const sl_view* view, double x, double y, sl_pick* pick);
/* Begins to build the ray tracer on another thread, unless there is one. Until it is there, picks wait for it, and
 * frames do not: sl_engine_info.preparing_picks. */
SL_API sl_status sl_engine_prepare_picks(sl_engine engine);
SL_API sl_status sl_engine_pick_ray(sl_engine engine, const sl_ray* ray, sl_pick* pick);
/* Items with any part (SL_REGION_CROSSING) or with all of them (SL_REGION_WHOLLY) in x0, y0, x1, y1 of the image,
 * hidden or not, in rising order. */
SL_API sl_status sl_engine_items_in(sl_engine engine, const sl_view* view, const double rectangle[4], int32_t rule,
                                    sl_item* items, size_t capacity, size_t* count);
/* The same for what up to SL_MAX_SECTIONS planes keep. */
SL_API sl_status sl_engine_items_in_planes(sl_engine engine, const sl_plane* planes, size_t plane_count, int32_t rule,
                                           uint32_t layers, sl_item* items, size_t capacity, size_t* count);
/* Items that the rectangle shows, in rising order, found with 1 to 1024 samples a pixel. */
SL_API sl_status sl_engine_visible_items_in(sl_engine engine, const sl_view* view, const double rectangle[4],
                                            int32_t samples, sl_visible_item* items, size_t capacity, size_t* count);

/* --- overrides: what one engine shows otherwise than its scene says ---------------------------------------------- */
/* From the next frame on, until the items are removed. All fail, and change nothing, where an item or node was unknown
 * at the last sl_engine_commit(). */

typedef struct sl_item_style {
  uint32_t size;
  int32_t use_colour; /* 0: the material's colour */
  float colour[3];    /* sRGB, 0 to 1 */
  float alpha;        /* 0 to 1, times the material's */
  int32_t outline;    /* draw a line around what the image shows of the item */
  int32_t ghost;      /* draw a faint shell that hides nothing; picks go through it */
} sl_item_style;
#define SL_ITEM_STYLE_INIT \
  { sizeof(sl_item_style), 0, {0.0f, 0.0f, 0.0f}, 1.0f, 0, 0 }

SL_API sl_status sl_engine_set_override(sl_engine engine, const sl_item* items, size_t item_count,
                                        const sl_item_style* style);
/* With null items of all; hidden ones stay hidden. */
SL_API sl_status sl_engine_clear_override(sl_engine engine, const sl_item* items, size_t item_count);
/* Hidden items are not drawn, hide nothing, and no query or pick finds them. 0 shows them again, unless the scene hides
 * them. */
SL_API sl_status sl_engine_set_hidden(sl_engine engine, const sl_item* items, size_t item_count, int32_t hidden);
/* Hides all items but those below the nodes, and shows these. */
SL_API sl_status sl_engine_isolate(sl_engine engine, const sl_node* nodes, size_t node_count);
SL_API sl_status sl_engine_show_all(sl_engine engine);
/* The style that sl_engine_set_override() gave an item; `there` is 0 where it shows as the scene says.
 * Fails with an item that was unknown at the last sl_engine_commit(). */
SL_API sl_status sl_engine_get_override(sl_engine engine, sl_item item, int32_t* there, sl_item_style* style);
/* Items with such a style, in rising order. */
SL_API sl_status sl_engine_overridden_items(sl_engine engine, sl_item* items, size_t capacity, size_t* count);
/* Whether sl_engine_set_hidden() or sl_engine_isolate() hides an item, which fails with an unknown one, too; and all
 * those that they hide. */
SL_API sl_status sl_engine_is_hidden(sl_engine engine, sl_item item, int32_t* hidden);
SL_API sl_status sl_engine_hidden_items(sl_engine engine, sl_item* items, size_t capacity, size_t* count);
/* Items that hang on the nodes and on all nodes below them, in rising order: those that are known as of the last
 * sl_engine_commit(). For all functions that take items. */
SL_API sl_status sl_engine_items_below(sl_engine engine, const sl_node* nodes, size_t node_count, sl_item* items,
                                       size_t capacity, size_t* count);

/* --- scenes larger than memory: sightline/engine/paged_engine.h -------------------------------------------------- */
/* Draws scene caches page by page, within a limit of memory (docs/guide/out-of-core.md). Calls on one engine wait for
 * each other; those within its progress give SL_ERROR_BUSY. */

typedef struct sl_paged_config {
  uint32_t size;
  int32_t width, height;
  int32_t ids;      /* an image of item ids beside colour and depth */
  double lod_error; /* as of sl_engine_config, by the levels of detail that the caches hold */
  /* Bytes that the whole process may have in memory, and its buffers on a GPU where that is main memory. Must be set.
   */
  uint64_t memory_limit;
  double refine_ms;          /* for which a frame of a view that stays takes in pages before it shows what it has */
  int32_t loading_bar;       /* in images that are not complete: the share of their leaves that are drawn */
  int32_t context_platform;  /* SL_CONTEXT_...: of the offscreen context */
  const char* program_cache; /* folder that keeps linked programs; null: the user's cache folder; "": none */
  /* Called in sl_paged_engine_create() alone, with the share that is opened, 0 to 1. Returning 0 before 1 cancels. May
   * be null. */
  int32_t (*progress)(double share, void* user);
  void* progress_user;
  int32_t gl_debug; /* collect driver messages: sl_paged_engine_take_gl_errors() */
  int32_t reserved; /* 0 */
} sl_paged_config;
#define SL_PAGED_CONFIG_INIT \
  { sizeof(sl_paged_config), 1280, 720, 0, 0.0, 0, 100.0, 1, SL_CONTEXT_AUTOMATIC, NULL, NULL, NULL, 0, 0 }

/* PagedReport in paged_engine.h says more. */
typedef struct sl_paged_report {
  uint32_t size;
  int32_t complete; /* nothing is missing that can be read */
  uint64_t frame;   /* frames before this one */
  double frame_ms;
  int64_t leaves, pending;              /* in the view; of these, not drawn and not known to be hidden */
  int64_t placeholders, coarse_items;   /* splats, and items by their coarsest levels, drawn in their place */
  int64_t items_drawn;                  /* into the image so far */
  uint32_t resident, coarse_resident;   /* pages in memory; those of coarsest levels */
  uint64_t loaded, coarse_loaded;       /* read since the start */
  uint64_t evicted, prefetched, failed; /* given up; read for no image yet; that cannot be read */
  uint64_t memory;                      /* bytes of the process; 0 where the system does not say */
} sl_paged_report;
#define SL_PAGED_REPORT_INIT \
  { sizeof(sl_paged_report), 0, 0, 0.0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0 }

typedef struct sl_paged_info {
  uint32_t size;
  int32_t width, height; /* of the image */
  uint32_t pages;        /* of the scene */
  uint64_t items;
  sl_box bounds;                   /* of all items, without those that lie too far from all others */
  uint64_t page_bytes, page_limit; /* of pages in memory and on their way; what these may come to */
} sl_paged_info;
#define SL_PAGED_INFO_INIT \
  { sizeof(sl_paged_info), 0, 0, 0, 0, {{0}, {0}}, 0, 0 }

/* Opens a scene cache (.slc), or all of a folder as parts of one scene, and makes an offscreen context. Files must not
 * be changed in place while the engine lives. */
SL_API sl_status sl_paged_engine_create(const char* path, const sl_paged_config* config, sl_paged_engine* engine);
/* Waits for the page that is being read. */
SL_API sl_status sl_paged_engine_destroy(sl_paged_engine engine);
/* Draws what is in memory of the view, and asks for what is not. The same view again goes on with the image. `report`
 * may be null. */
SL_API sl_status sl_paged_engine_frame(sl_paged_engine engine, const sl_view* view, sl_paged_report* report);
/* Waits until a page has arrived for the next frame, at most so long. `arrived` becomes 0, at once, where none is on
 * its way. */
SL_API sl_status sl_paged_engine_wait(sl_paged_engine engine, double seconds, int32_t* arrived);
/* Draws until the image is complete. `progress` (may be null) is called now and then with the share of the view's
 * leaves that are drawn; where it returns 0, the image stays as it is, and report->complete says so. `report` may be
 * null. */
SL_API sl_status sl_paged_engine_settle(sl_paged_engine engine, const sl_view* view,
                                        int32_t (*progress)(double share, void* user), void* user,
                                        sl_paged_report* report);
SL_API sl_status sl_paged_engine_get(sl_paged_engine engine, sl_paged_info* info);
/* As GL names it. */
SL_API sl_status sl_paged_engine_renderer(sl_paged_engine engine, sl_text* text);
/* Why pages could not be read, and what the driver has complained of, a line each: as sl_engine_take_gl_errors(). */
SL_API sl_status sl_paged_engine_take_errors(sl_paged_engine engine, sl_text* text);
SL_API sl_status sl_paged_engine_take_gl_errors(sl_paged_engine engine, sl_text* text);
/* The image of the last frame, as sl_engine_read_colour() and its like have it. SL_ERROR_BUSY before the first frame.
 */
SL_API sl_status sl_paged_engine_read_colour(sl_paged_engine engine, uint8_t* rgb, size_t capacity);
SL_API sl_status sl_paged_engine_read_ids(sl_paged_engine engine, uint32_t* ids, size_t capacity);
SL_API sl_status sl_paged_engine_read_depth(sl_paged_engine engine, float* metres, size_t capacity);

#ifdef __cplusplus
}
#endif

#endif
