# Where `cmake --install` puts the program and what it needs. The program looks for share/gantry beside its bin first
# (app/cli/shipped.cpp), so that the tree may be moved as a whole.
install(TARGETS gantry RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
set(data ${CMAKE_INSTALL_DATADIR}/gantry)
install(DIRECTORY config/machines config/drives config/devices DESTINATION ${data}/config FILES_MATCHING PATTERN "*.yaml")
install(DIRECTORY config/schema DESTINATION ${data}/config FILES_MATCHING PATTERN "*.json")
install(DIRECTORY recipes/ DESTINATION ${data}/recipes FILES_MATCHING PATTERN "*.yaml" PATTERN "*.csv" PATTERN "*.json")
install(FILES README.md LICENSE THIRD_PARTY.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR}
  FILES_MATCHING PATTERN "*.md" PATTERN "*.png" PATTERN "*.svg" PATTERN "*.jpg")
