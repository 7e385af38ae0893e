// The catalogue of networks and the profile of one.

#include "altiro3D/depth_network.hpp"
#include "fuzz.hpp"

using namespace altiro3D;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const fuzz::Directory directory;
    const std::filesystem::path file = directory.file("a.json", fuzz::textOf(data, size));
    fuzz::reads([&] { validate(readNetworkProfile(file)); });
    fuzz::reads([&] {
        const std::vector<NetworkProfile> catalog = readModelCatalog(file);
        for (const NetworkProfile& profile : catalog) {
            validate(profile);
            fuzz::require(findProfile(catalog, profile.file) == &profile,
                          "a file stands for one network");
        }
    });
    return 0;
}
