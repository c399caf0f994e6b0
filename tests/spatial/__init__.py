"""The runtime in space, judged by physics: closed forms, conservation laws, planar scenes and the complex step."""
