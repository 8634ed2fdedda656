// A Vulkan layer that writes down how each pipeline is made, for the replayer to make it again elsewhere.
//
// Files go to the folder that ISA_FOLDER names (default: pipelines), by the name that the app gives the pipeline and the hash of the
// recipe: equal pipelines are one file. What wgpu and most others use is kept; what is not is said once, on stderr.
#include "recipe.h"
#include <errno.h>
#include <pthread.h>
#include <sys/stat.h>
#include <unistd.h>
#include <vulkan/vk_layer.h>

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

// --- What was made, by handle ---

typedef struct {
    VkObjectType type;
    uint64_t handle;
    Recipe recipe; // of all but pipelines
    uint32_t hash; // of pipelines: its recipe is in a file
} Known;

static Known *known;
static size_t known_count;

static Known *find(VkObjectType type, uint64_t handle) {
    for (size_t i = 0; i < known_count; i++)
        if (known[i].type == type && known[i].handle == handle)
            return &known[i];
    return NULL;
}

// Drivers give a handle again after its object was destroyed: the newest holds.
static void remember(VkObjectType type, uint64_t handle, Recipe recipe, uint32_t hash) {
    Known *place = find(type, handle);
    if (!place) {
        known = realloc(known, (known_count + 1) * sizeof *known);
        place = memset(&known[known_count++], 0, sizeof *place);
    }
    free(place->recipe.bytes);
    *place = (Known){type, handle, recipe, hash};
}

static bool append_known(Recipe *recipe, VkObjectType type, uint64_t handle) {
    Known *place = find(type, handle);
    if (place)
        recipe_append(recipe, place->recipe.bytes, place->recipe.size);
    return place != NULL;
}

// --- Files ---

static const char *folder(void) {
    const char *named = getenv("ISA_FOLDER");
    return named && *named ? named : "pipelines";
}

static void make_folders(char *path) {
    for (char *slash = strchr(path + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = 0;
        if (mkdir(path, 0777) && errno != EEXIST)
            fprintf(stderr, "isa: %s: %s\n", path, strerror(errno));
        *slash = '/';
    }
}

static void path_of(char *path, size_t size, const char *name, uint32_t hash) {
    int start = snprintf(path, size, "%s/", folder());
    snprintf(path + start, size - start, "%.200s-%08x.pipeline", *name ? name : "unnamed", hash);
    // Slashes of a name are folders, but for those that lead elsewhere.
    for (char *at = path + start; *at; at++)
        if ((unsigned char)*at < ' ' || (*at == '/' && (at == path + start || at[1] == '/' || at[1] == '.')))
            *at = '_';
    make_folders(path);
}

static void write_pipeline(VkPipeline pipeline, Recipe recipe) {
    uint32_t hash = 2166136261; // FNV-1a
    for (size_t i = 0; i < recipe.size; i++)
        hash = (hash ^ (unsigned char)recipe.bytes[i]) * 16777619;
    char path[4096];
    path_of(path, sizeof path, "", hash);
    FILE *file = fopen(path, "wb");
    if (!file || fwrite(recipe.bytes, recipe.size, 1, file) != 1)
        fprintf(stderr, "isa: %s: %s\n", path, strerror(errno));
    if (file)
        fclose(file);
    free(recipe.bytes);
    remember(VK_OBJECT_TYPE_PIPELINE, (uint64_t)pipeline, (Recipe){0}, hash);
}

static void name_pipeline(uint64_t pipeline, const char *name) {
    Known *place = find(VK_OBJECT_TYPE_PIPELINE, pipeline);
    if (!place || !name)
        return;
    char from[4096], to[4096];
    path_of(from, sizeof from, "", place->hash);
    path_of(to, sizeof to, name, place->hash);
    // One that is made again keeps the time of the first: the order of files tells what was made before what.
    if ((!access(to, F_OK) ? unlink(from) : rename(from, to)) && errno != ENOENT) // named already
        fprintf(stderr, "isa: %s: %s\n", to, strerror(errno));
}

static void complain(const char *what) {
    static const char *said[64];
    for (size_t i = 0; i < 64; i++) {
        if (!said[i]) {
            said[i] = what;
            fprintf(stderr, "isa: not kept: %s\n", what);
        }
        if (said[i] == what)
            return;
    }
}

// --- The layers and the driver below ---

typedef struct {
    void *key; // instances and their physical devices share it, devices and their queues
    VkInstance instance;
    PFN_vkGetInstanceProcAddr of_instance;
    PFN_vkGetDeviceProcAddr of_device;
} Below;

static Below below[64];
static size_t below_count;

static Below *below_key(const void *dispatchable, bool add) {
    void *key = *(void *const *)dispatchable;
    pthread_mutex_lock(&lock);
    Below *found = NULL;
    for (size_t i = 0; i < below_count && !found; i++)
        if (below[i].key == key)
            found = &below[i];
    if (!found && add && below_count < sizeof below / sizeof *below) {
        found = &below[below_count++];
        found->key = key;
    }
    pthread_mutex_unlock(&lock);
    return found;
}

#define NEXT(device, function) ((PFN_##function)below_key(device, false)->of_device(device, #function))

static VKAPI_ATTR VkResult VKAPI_CALL create_instance(
    const VkInstanceCreateInfo *info, const VkAllocationCallbacks *allocator, VkInstance *instance) {
    VkLayerInstanceCreateInfo *link = (void *)info->pNext;
    while (link && !(link->sType == VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO && link->function == VK_LAYER_LINK_INFO))
        link = (void *)link->pNext;
    if (!link)
        return VK_ERROR_INITIALIZATION_FAILED;
    PFN_vkGetInstanceProcAddr next = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    VkResult result = ((PFN_vkCreateInstance)next(NULL, "vkCreateInstance"))(info, allocator, instance);
    Below *place = result ? NULL : below_key(*instance, true);
    if (place) {
        place->instance = *instance;
        place->of_instance = next;
    }
    return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL create_device(
    VkPhysicalDevice physical, const VkDeviceCreateInfo *info, const VkAllocationCallbacks *allocator, VkDevice *device) {
    VkLayerDeviceCreateInfo *link = (void *)info->pNext;
    while (link && !(link->sType == VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO && link->function == VK_LAYER_LINK_INFO))
        link = (void *)link->pNext;
    if (!link)
        return VK_ERROR_INITIALIZATION_FAILED;
    PFN_vkGetInstanceProcAddr next = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    PFN_vkGetDeviceProcAddr of_device = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    VkInstance instance = below_key(physical, false)->instance;
    VkResult result = ((PFN_vkCreateDevice)next(instance, "vkCreateDevice"))(physical, info, allocator, device);
    Below *place = result ? NULL : below_key(*device, true);
    if (place)
        place->of_device = of_device;
    return result;
}

// --- What is written down ---

static VKAPI_ATTR VkResult VKAPI_CALL create_shader_module(
    VkDevice device, const VkShaderModuleCreateInfo *info, const VkAllocationCallbacks *allocator, VkShaderModule *module) {
    VkResult result = NEXT(device, vkCreateShaderModule)(device, info, allocator, module);
    if (result)
        return result;
    Recipe recipe = {0};
    recipe_module(&recipe, (void *)info);
    pthread_mutex_lock(&lock);
    remember(VK_OBJECT_TYPE_SHADER_MODULE, (uint64_t)*module, recipe, 0);
    pthread_mutex_unlock(&lock);
    return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL create_set_layout(
    VkDevice device, const VkDescriptorSetLayoutCreateInfo *info, const VkAllocationCallbacks *allocator, VkDescriptorSetLayout *layout) {
    VkResult result = NEXT(device, vkCreateDescriptorSetLayout)(device, info, allocator, layout);
    if (result)
        return result;
    for (uint32_t i = 0; i < info->bindingCount; i++)
        if (info->pBindings[i].pImmutableSamplers)
            complain("immutable samplers");
    Recipe recipe = {0};
    recipe_set_layout(&recipe, (void *)info);
    pthread_mutex_lock(&lock);
    remember(VK_OBJECT_TYPE_DESCRIPTOR_SET_LAYOUT, (uint64_t)*layout, recipe, 0);
    pthread_mutex_unlock(&lock);
    return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL create_layout(
    VkDevice device, const VkPipelineLayoutCreateInfo *info, const VkAllocationCallbacks *allocator, VkPipelineLayout *layout) {
    VkResult result = NEXT(device, vkCreatePipelineLayout)(device, info, allocator, layout);
    if (result)
        return result;
    Recipe recipe = {0};
    recipe_layout(&recipe, (void *)info);
    pthread_mutex_lock(&lock);
    for (uint32_t i = 0; i < info->setLayoutCount; i++) {
        VkDescriptorSetLayoutCreateInfo empty = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
        if (!append_known(&recipe, VK_OBJECT_TYPE_DESCRIPTOR_SET_LAYOUT, (uint64_t)info->pSetLayouts[i]))
            recipe_set_layout(&recipe, &empty);
    }
    remember(VK_OBJECT_TYPE_PIPELINE_LAYOUT, (uint64_t)*layout, recipe, 0);
    pthread_mutex_unlock(&lock);
    return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL create_render_pass(
    VkDevice device, const VkRenderPassCreateInfo *info, const VkAllocationCallbacks *allocator, VkRenderPass *pass) {
    VkResult result = NEXT(device, vkCreateRenderPass)(device, info, allocator, pass);
    if (result)
        return result;
    Recipe recipe = {0};
    recipe_render_pass(&recipe, (void *)info);
    pthread_mutex_lock(&lock);
    remember(VK_OBJECT_TYPE_RENDER_PASS, (uint64_t)*pass, recipe, 0);
    pthread_mutex_unlock(&lock);
    return result;
}

static bool begin(Recipe *recipe, bool graphics, VkPipelineLayout layout, uint32_t count, const VkPipelineShaderStageCreateInfo *stages) {
    RecipeHead head = {RECIPE_MAGIC, graphics};
    recipe_append(recipe, &head, sizeof head);
    bool whole = append_known(recipe, VK_OBJECT_TYPE_PIPELINE_LAYOUT, (uint64_t)layout);
    recipe_append(recipe, &count, sizeof count);
    for (uint32_t i = 0; i < count; i++) {
        if (stages[i].pNext)
            complain("what is chained to a shader stage");
        recipe_stage(recipe, (void *)&stages[i]);
        whole = append_known(recipe, VK_OBJECT_TYPE_SHADER_MODULE, (uint64_t)stages[i].module) && whole;
    }
    return whole;
}

static void end(Recipe recipe, bool whole, VkPipeline pipeline) {
    if (whole && pipeline)
        write_pipeline(pipeline, recipe);
    else
        complain("a pipeline whose layout, render pass or shader was made in a way that is not known");
}

static VKAPI_ATTR VkResult VKAPI_CALL create_compute_pipelines(
    VkDevice device, VkPipelineCache cache, uint32_t count, const VkComputePipelineCreateInfo *infos,
    const VkAllocationCallbacks *allocator, VkPipeline *pipelines) {
    VkResult result = NEXT(device, vkCreateComputePipelines)(device, cache, count, infos, allocator, pipelines);
    pthread_mutex_lock(&lock);
    for (uint32_t i = 0; i < count && result >= 0; i++) {
        Recipe recipe = {0};
        bool whole = begin(&recipe, false, infos[i].layout, 1, &infos[i].stage);
        end(recipe, whole, pipelines[i]);
    }
    pthread_mutex_unlock(&lock);
    return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL create_graphics_pipelines(
    VkDevice device, VkPipelineCache cache, uint32_t count, const VkGraphicsPipelineCreateInfo *infos,
    const VkAllocationCallbacks *allocator, VkPipeline *pipelines) {
    VkResult result = NEXT(device, vkCreateGraphicsPipelines)(device, cache, count, infos, allocator, pipelines);
    pthread_mutex_lock(&lock);
    for (uint32_t i = 0; i < count && result >= 0; i++) {
        if (infos[i].pNext || infos[i].pRasterizationState->pNext)
            complain("what is chained to a graphics pipeline");
        Recipe recipe = {0};
        bool whole = begin(&recipe, true, infos[i].layout, infos[i].stageCount, infos[i].pStages);
        whole = append_known(&recipe, VK_OBJECT_TYPE_RENDER_PASS, (uint64_t)infos[i].renderPass) && whole;
        recipe_graphics(&recipe, (void *)&infos[i]);
        end(recipe, whole, pipelines[i]);
    }
    pthread_mutex_unlock(&lock);
    return result;
}

static VKAPI_ATTR VkResult VKAPI_CALL set_name(VkDevice device, const VkDebugUtilsObjectNameInfoEXT *info) {
    if (info->objectType == VK_OBJECT_TYPE_PIPELINE) {
        pthread_mutex_lock(&lock);
        name_pipeline(info->objectHandle, info->pObjectName);
        pthread_mutex_unlock(&lock);
    }
    PFN_vkSetDebugUtilsObjectNameEXT next = NEXT(device, vkSetDebugUtilsObjectNameEXT);
    return next ? next(device, info) : VK_SUCCESS;
}

// --- How the loader finds all that ---

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL get_instance_address(VkInstance instance, const char *name);
static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL get_device_address(VkDevice device, const char *name);

static PFN_vkVoidFunction own(const char *name, bool of_device) {
    static const struct {
        const char *name;
        bool of_device;
        void *function;
    } functions[] = {
        {"vkGetInstanceProcAddr", false, get_instance_address},
        {"vkCreateInstance", false, create_instance},
        {"vkCreateDevice", false, create_device},
        {"vkGetDeviceProcAddr", true, get_device_address},
        {"vkCreateShaderModule", true, create_shader_module},
        {"vkCreateDescriptorSetLayout", true, create_set_layout},
        {"vkCreatePipelineLayout", true, create_layout},
        {"vkCreateRenderPass", true, create_render_pass},
        {"vkCreateComputePipelines", true, create_compute_pipelines},
        {"vkCreateGraphicsPipelines", true, create_graphics_pipelines},
        {"vkSetDebugUtilsObjectNameEXT", true, set_name},
    };
    for (size_t i = 0; i < sizeof functions / sizeof *functions; i++)
        if (!strcmp(functions[i].name, name) && (functions[i].of_device || !of_device))
            return (PFN_vkVoidFunction)functions[i].function;
    return NULL;
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL get_device_address(VkDevice device, const char *name) {
    PFN_vkVoidFunction function = own(name, true);
    return function ? function : below_key(device, false)->of_device(device, name);
}

static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL get_instance_address(VkInstance instance, const char *name) {
    PFN_vkVoidFunction function = own(name, false);
    return function || !instance ? function : below_key(instance, false)->of_instance(instance, name);
}

VK_LAYER_EXPORT VKAPI_ATTR VkResult VKAPI_CALL vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface *interface) {
    if (interface->loaderLayerInterfaceVersion > 2)
        interface->loaderLayerInterfaceVersion = 2;
    interface->pfnGetInstanceProcAddr = get_instance_address;
    interface->pfnGetDeviceProcAddr = get_device_address;
    interface->pfnGetPhysicalDeviceProcAddr = NULL;
    return VK_SUCCESS;
}
