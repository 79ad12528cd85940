# install, find_package(plumbline) and pkg-config
