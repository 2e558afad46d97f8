// An invocation for each of `count` things. Groups are dealt out in two dimensions, since one has a limit.
layout(local_size_x = 256) in;
layout(location = 0) uniform uint count;

uint group() { return gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x; }
uint invocation() { return group() * gl_WorkGroupSize.x + gl_LocalInvocationIndex; }
