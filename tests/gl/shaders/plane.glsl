// The depth of everything the triangle draws.
float plane_depth() { return u_depth; }
