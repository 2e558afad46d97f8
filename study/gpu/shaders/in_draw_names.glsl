// What the renderer's vertex stage gives to its fragment stage goes through the geometry stage under other names; and
// the test comes before its main.
#define local_from_eye vertex_local_from_eye
#define record vertex_record
#define main place_proxy
