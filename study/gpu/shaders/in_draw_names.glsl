// What the renderer's vertex stage gives to its fragment stage goes through the geometry stage under other names; and
// the test comes before its main.
#define local_from_eye vertex_local_from_eye
#define anchor vertex_anchor
#define main place_proxy
