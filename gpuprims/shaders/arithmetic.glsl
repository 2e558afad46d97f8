// Handles cancellation. A discriminant is the difference of two terms, which are nearly equal where a ray grazes a
// solid. There it is computed again in double, where products of two floats are exact. That affects silhouettes, a few
// pixels of many.

// Terms cancel when their difference is smaller than this part of them.
const float kCancels = 0.02;

float cross_product(vec2 a, vec2 b) { return a.x * b.y - a.y * b.x; }
double cross_product(dvec2 a, dvec2 b) { return a.x * b.y - a.y * b.x; }
