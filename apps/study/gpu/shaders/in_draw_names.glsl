// The test comes before the renderer's own main.
#define main place_proxy
