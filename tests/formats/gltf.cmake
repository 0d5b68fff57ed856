# The tests of glTF, GLB and Draco.
find_package(nlohmann_json REQUIRED)
add_executable(gltf_samples gltf_samples.cpp)
target_link_libraries(gltf_samples PRIVATE test_support diesink::formats)
foreach(name gltf_test gltf_draco_test gltf_hostile_test gltf_second_readers_test)
  add_executable(${name} ${name}.cpp)
  target_link_libraries(${name} PRIVATE test_support diesink::formats nlohmann_json::nlohmann_json)
  gtest_discover_tests(${name})
endforeach()
target_compile_definitions(gltf_second_readers_test PRIVATE
  DIESINK_GLTF_SAMPLES="$<TARGET_FILE:gltf_samples>")
add_dependencies(gltf_second_readers_test gltf_samples)
