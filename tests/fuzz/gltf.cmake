# The readers of glTF and of the Draco streams in it (scripts/fuzz_gltf.sh runs both for longer).
add_fuzzed_reader(gltf gltf_fuzz.cpp)
add_fuzzed_reader(gltf_draco gltf_draco_fuzz.cpp)
