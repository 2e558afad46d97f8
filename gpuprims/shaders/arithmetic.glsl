// What cancels. A discriminant is the difference of two terms that are nearly equal where a ray grazes a solid. There it is computed
// again in double, in which products of two floats are exact: at silhouettes, a few pixels of many.

// Where the difference is smaller than this part of its terms.
const float kCancels = 0.02;

float cross_product(vec2 a, vec2 b) { return a.x * b.y - a.y * b.x; }
double cross_product(dvec2 a, dvec2 b) { return a.x * b.y - a.y * b.x; }
