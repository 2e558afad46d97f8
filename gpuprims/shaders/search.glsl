// Searches the first crossing of a ray with a solid that the view shows. It does not know the view: the caller says
// which parts of the ray are kept. A solid is given as the spans of the ray inside it. Where a kept part begins within
// such a span at a section plane, the solid is cut, and the cut face is visible.

const float kNoHit = 3.0e38;

// Faces of a solid. Some kinds have more, above these.
const int kSide = 0, kBottom = 1, kTop = 2, kCut = 3;
const int kBottomLevel = 8, kTopLevel = 9;  // replace an end plane that does not close the solid

struct Search {
  vec2 first, second;          // the kept parts of the ray; `second` begins behind the end of `first`, or is empty
  bool cut_first, cut_second;  // whether they begin at a section plane
  uint hidden;                 // one bit per face that is not drawn; the solid is closed there all the same
  float t;                     // kNoHit while nothing was found
  int face;
};

Search search_within(vec2 kept, uint hidden) {
  return Search(kept, vec2(1.0, -1.0), false, false, hidden, kNoHit, kSide);
}

Search search_all() { return search_within(vec2(-kNoHit, kNoHit), 0u); }

void offer(inout Search s, float t, int face) {
  if (t < s.t) {
    s.t = t;
    s.face = face;
  }
}

bool shown(Search s, int face) { return (s.hidden >> uint(face) & 1u) == 0u; }

// How far internal end caps reach beyond their plane, in radii: into the neighbour that covers them, which may be that far
// away (kJointGap in gpuprims/internal/joints.h). So no ray passes between the two, and a section that lies in the joint
// cuts at least one of them.
const float kInternalCapOverlap = 2e-4;

float internal_cap_overlap(Search s, int face) { return shown(s, face) ? 0.0 : kInternalCapOverlap; }

void offer_part(inout Search s, float t0, int face0, float t1, int face1, vec2 kept, bool cut) {
  if (!(max(t0, kept.x) <= min(t1, kept.y))) return;
  if (t0 >= kept.x) {
    if (shown(s, face0)) {
      offer(s, t0, face0);
      return;
    }
  } else if (cut) {
    offer(s, kept.x, kCut);
    return;
  }
  if (t1 <= kept.y && shown(s, face1)) offer(s, t1, face1);  // the surface seen from inside
}

// The ray is inside the solid from t0 to t1, where it crosses the named faces.
void offer_span(inout Search s, float t0, int face0, float t1, int face1) {
  offer_part(s, t0, face0, t1, face1, s.first, s.cut_first);
  if (s.second.x <= s.second.y) offer_part(s, t0, face0, t1, face1, s.second, s.cut_second);
}

// A span of a ray and the faces at its ends.
struct Span {
  float from, to;
  int from_face, to_face;
};

Span whole_line() { return Span(-kNoHit, kNoHit, kSide, kSide); }

bool is_empty(Span s) { return !(s.from <= s.to); }

void enter(inout Span s, float t, int face) {
  if (t > s.from) {
    s.from = t;
    s.from_face = face;
  }
}

void leave(inout Span s, float t, int face) {
  if (t < s.to) {
    s.to = t;
    s.to_face = face;
  }
}

// Keeps the part with value + t slope >= 0.
void clip(inout Span s, float value, float slope, int face) {
  if (slope > 0.0) enter(s, -value / slope, face);
  else if (slope < 0.0) leave(s, -value / slope, face);
  else if (!(value >= 0.0)) s.to = -kNoHit, s.from = kNoHit;
}

Span common_part(Span a, Span b) {
  enter(a, b.from, b.from_face);
  leave(a, b.to, b.to_face);
  return a;
}

// Moves a ray's origin to z = 0, if that point is within `distance` of the axis, and returns the move in t. Flat solids
// are intersected from there, where a rounded z does not become a wrong radius.
float move_to_level(inout vec3 o, vec3 d, float distance) {
  if (d.z == 0.0) return 0.0;  // no number may be NaN: GL need not know what such compare to
  float t = -o.z / d.z;
  vec2 level = o.xy + t * d.xy;
  if (!(dot(level, level) < distance * distance)) return 0.0;
  o = vec3(level, 0.0);
  return t;
}

// `start`: value of t where the span counts from.
void offer_span(inout Search search, Span s, float start) {
  // Ends at or near infinity come from shapes that the ray never leaves: rounding errors of bad data, which show
  // nothing.
  const float kBeyond = 1.0e18;
  if (is_empty(s) || s.from <= -kBeyond || s.to >= kBeyond) return;
  offer_span(search, start + s.from, s.from_face, start + s.to, s.to_face);
}

void offer_span(inout Search search, Span s) { offer_span(search, s, 0.0); }
