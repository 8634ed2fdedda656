// Makes the pipelines that the layer wrote down on the first Vulkan device there is, and prints what its compiler says of each shader.
//
//   replay [--text FOLDER] <paths
//
// Reads paths of recipes from stdin, a line each, and prints a line of JSON for each shader: its name, hash, stage, bytes of SPIR-V,
// invocations of a workgroup and of a subgroup, and the statistics under the names that the driver has for them. With --text, writes the SPIR-V and what
// the compiler made of it (its intermediate languages, the assembly) into a folder too.
#include "recipe.h"
#include <ctype.h>
#include <errno.h>
#include <sys/stat.h>

static VkDevice device;
static char device_name[VK_MAX_PHYSICAL_DEVICE_NAME_SIZE];
static const char *text_folder;

static void check(VkResult result, const char *what) {
    if (result) {
        fprintf(stderr, "isa: %s: error %d\n", what, result);
        exit(1);
    }
}

// All of Vulkan 1.3 that the device has, and the robustness that wgpu asks for: it changes what is compiled.
static void make_device(void) {
    VkApplicationInfo app = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_3};
    VkInstanceCreateInfo instance_info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, .pApplicationInfo = &app};
    VkInstance instance;
    check(vkCreateInstance(&instance_info, NULL, &instance), "no Vulkan");
    uint32_t count = 1;
    VkPhysicalDevice physical = NULL;
    vkEnumeratePhysicalDevices(instance, &count, &physical);
    check(physical ? VK_SUCCESS : VK_ERROR_DEVICE_LOST, "no device");
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(physical, &properties);
    strcpy(device_name, properties.deviceName);

    VkPhysicalDeviceVulkan11Features v11 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES};
    VkPhysicalDeviceVulkan12Features v12 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES, .pNext = &v11};
    VkPhysicalDeviceVulkan13Features v13 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES, .pNext = &v12};
    VkPhysicalDeviceRobustness2FeaturesEXT robustness = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ROBUSTNESS_2_FEATURES_EXT, .pNext = &v13};
    VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR executables = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PIPELINE_EXECUTABLE_PROPERTIES_FEATURES_KHR, .pNext = &robustness};
    VkPhysicalDeviceFeatures2 features = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = &executables};
    vkGetPhysicalDeviceFeatures2(physical, &features);
    robustness.nullDescriptor = false;

    float priority = 1;
    VkDeviceQueueCreateInfo queue = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, .queueCount = 1, .pQueuePriorities = &priority};
    const char *extensions[] = {VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME, VK_EXT_ROBUSTNESS_2_EXTENSION_NAME};
    VkDeviceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                               .pNext = &features,
                               .queueCreateInfoCount = 1,
                               .pQueueCreateInfos = &queue,
                               .enabledExtensionCount = sizeof extensions / sizeof *extensions,
                               .ppEnabledExtensionNames = extensions};
    check(vkCreateDevice(physical, &info, NULL, &device), "the device lacks what is needed");
}

// --- A recipe, made ---

static Recipe read_recipe(const char *path) {
    Recipe recipe = {.reading = true};
    FILE *file = fopen(path, "rb");
    struct stat status;
    if (file && !fstat(fileno(file), &status)) {
        recipe.size = (size_t)status.st_size;
        recipe.bytes = malloc(recipe.size + 8);
        if (fread(recipe.bytes, 1, recipe.size, file) != recipe.size)
            recipe.size = 0;
    }
    if (file)
        fclose(file);
    return recipe;
}

static VkPipelineLayout make_layout(Recipe *recipe) {
    VkPipelineLayoutCreateInfo info = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    recipe_layout(recipe, &info);
    VkDescriptorSetLayout *sets = calloc(info.setLayoutCount + 1, sizeof *sets);
    for (uint32_t i = 0; i < info.setLayoutCount; i++) {
        VkDescriptorSetLayoutCreateInfo set = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
        recipe_set_layout(recipe, &set);
        check(vkCreateDescriptorSetLayout(device, &set, NULL, &sets[i]), "a set layout");
    }
    info.pSetLayouts = sets;
    VkPipelineLayout layout;
    check(vkCreatePipelineLayout(device, &info, NULL, &layout), "a pipeline layout");
    return layout;
}

static VkPipelineShaderStageCreateInfo *make_stages(Recipe *recipe, uint32_t *count, VkShaderModuleCreateInfo **modules) {
    recipe_item(recipe, count, sizeof *count);
    VkPipelineShaderStageCreateInfo *stages = calloc(*count + 1, sizeof *stages);
    *modules = calloc(*count + 1, sizeof **modules);
    for (uint32_t i = 0; i < *count; i++) {
        stages[i].sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
        recipe_stage(recipe, &stages[i]);
        VkShaderModuleCreateInfo *module = &(*modules)[i];
        module->sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
        recipe_module(recipe, module);
        check(vkCreateShaderModule(device, module, NULL, &stages[i].module), "a shader module");
    }
    return stages;
}

static VkPipeline make_pipeline(
    Recipe *recipe, VkPipelineShaderStageCreateInfo **stages, VkShaderModuleCreateInfo **modules, uint32_t *count) {
    RecipeHead head;
    recipe_item(recipe, &head, sizeof head);
    if (strcmp(head.magic, RECIPE_MAGIC))
        return NULL;
    VkPipelineLayout layout = make_layout(recipe);
    *stages = make_stages(recipe, count, modules);
    VkPipelineCreateFlags capture = VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR |
                                    (text_folder ? VK_PIPELINE_CREATE_CAPTURE_INTERNAL_REPRESENTATIONS_BIT_KHR : 0);
    VkPipeline pipeline = NULL;
    if (!head.graphics) {
        VkComputePipelineCreateInfo info = {
            .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO, .flags = capture, .stage = **stages, .layout = layout};
        vkCreateComputePipelines(device, NULL, 1, &info, NULL, &pipeline);
        return pipeline;
    }
    VkRenderPassCreateInfo pass_info = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO};
    recipe_render_pass(recipe, &pass_info);
    VkGraphicsPipelineCreateInfo info = {.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO};
    recipe_graphics(recipe, &info);
    check(vkCreateRenderPass(device, &pass_info, NULL, &info.renderPass), "a render pass");
    info.flags |= capture;
    info.layout = layout;
    info.stageCount = *count;
    info.pStages = *stages;
    vkCreateGraphicsPipelines(device, NULL, 1, &info, NULL, &pipeline);
    return pipeline;
}

// --- What is said of it ---

static const char *stage_name(VkShaderStageFlags stages) {
    return stages & VK_SHADER_STAGE_COMPUTE_BIT    ? "compute"
           : stages & VK_SHADER_STAGE_FRAGMENT_BIT ? "fragment"
           : stages & VK_SHADER_STAGE_VERTEX_BIT   ? "vertex"
                                                   : "other";
}

// Invocations of a workgroup, as the SPIR-V of a compute shader says; 0 of others.
static uint32_t workgroup_size(const VkPipelineShaderStageCreateInfo *stage, const VkShaderModuleCreateInfo *module) {
    enum { ENTRY_POINT = 15, EXECUTION_MODE = 16, COMPUTE = 5, LOCAL_SIZE = 17 };
    const uint32_t *end = module->pCode + module->codeSize / 4;
    uint32_t entry = 0;
    for (const uint32_t *word = module->pCode + 5; word < end && *word >> 16; word += *word >> 16) {
        uint32_t operation = *word & 0xffff;
        if (operation == ENTRY_POINT && word[1] == COMPUTE && !strcmp((const char *)&word[3], stage->pName))
            entry = word[2];
        if (operation == EXECUTION_MODE && entry && word[1] == entry && word[2] == LOCAL_SIZE)
            return word[3] * word[4] * word[5];
    }
    return 0;
}

static void print_string(const char *string) {
    putchar('"');
    for (; *string; string++)
        printf((unsigned char)*string < ' ' ? "\\u%04x" : strchr("\"\\", *string) ? "\\%c" : "%c", *string);
    putchar('"');
}

static void print_statistics(VkPipelineExecutableInfoKHR *which) {
    PFN_vkGetPipelineExecutableStatisticsKHR get =
        (PFN_vkGetPipelineExecutableStatisticsKHR)vkGetDeviceProcAddr(device, "vkGetPipelineExecutableStatisticsKHR");
    uint32_t count = 0;
    get(device, which, &count, NULL);
    VkPipelineExecutableStatisticKHR *statistics = calloc(count + 1, sizeof *statistics);
    for (uint32_t i = 0; i < count; i++)
        statistics[i].sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_STATISTIC_KHR;
    get(device, which, &count, statistics);
    for (uint32_t i = 0; i < count; i++) {
        VkPipelineExecutableStatisticKHR *statistic = &statistics[i];
        putchar(',');
        print_string(statistic->name);
        putchar(':');
        switch (statistic->format) {
        case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_BOOL32_KHR: printf("%s", statistic->value.b32 ? "true" : "false"); break;
        case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_INT64_KHR: printf("%lld", (long long)statistic->value.i64); break;
        case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_UINT64_KHR: printf("%llu", (unsigned long long)statistic->value.u64); break;
        default: printf("%g", statistic->value.f64);
        }
    }
    free(statistics);
}

// Into the text folder: the pipeline's name without its folders, the stage, what it is.
static void write_text(const char *path, const char *stage, const char *what, const void *text, size_t size) {
    const char *base = strrchr(path, '/') ? strrchr(path, '/') + 1 : path;
    char to[4096];
    int start = snprintf(to, sizeof to, "%s/", text_folder);
    snprintf(to + start, sizeof to - start, "%.*s.%s.%s", (int)(strlen(base) - strlen(".pipeline")), base, stage, what);
    for (char *at = to + start; *at; at++)
        if (!isalnum((unsigned char)*at) && !strchr(".-_", *at))
            *at = '_';
    FILE *file = fopen(to, "wb");
    if (!file || (size && fwrite(text, size, 1, file) != 1))
        fprintf(stderr, "isa: %s: %s\n", to, strerror(errno));
    if (file)
        fclose(file);
}

static void write_texts(const char *path, const char *stage, VkPipelineExecutableInfoKHR *which) {
    PFN_vkGetPipelineExecutableInternalRepresentationsKHR get = (PFN_vkGetPipelineExecutableInternalRepresentationsKHR)
        vkGetDeviceProcAddr(device, "vkGetPipelineExecutableInternalRepresentationsKHR");
    uint32_t count = 0;
    get(device, which, &count, NULL);
    VkPipelineExecutableInternalRepresentationKHR *texts = calloc(count + 1, sizeof *texts);
    for (uint32_t i = 0; i < count; i++)
        texts[i].sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_INTERNAL_REPRESENTATION_KHR;
    get(device, which, &count, texts);
    for (uint32_t i = 0; i < count; i++)
        texts[i].pData = malloc(texts[i].dataSize + 1);
    get(device, which, &count, texts);
    for (uint32_t i = 0; i < count; i++) {
        char what[VK_MAX_DESCRIPTION_SIZE + 8];
        snprintf(what, sizeof what, "%s.txt", texts[i].name);
        write_text(path, stage, what, texts[i].pData, strnlen(texts[i].pData, texts[i].dataSize));
        free(texts[i].pData);
    }
    free(texts);
}

// Bytes of the stage's SPIR-V; 0 if the pipeline has no such stage.
static size_t spirv_size(
    VkShaderStageFlags stage, const VkPipelineShaderStageCreateInfo *stages, const VkShaderModuleCreateInfo *modules, uint32_t count) {
    for (uint32_t i = 0; i < count; i++)
        if (stages[i].stage & stage)
            return modules[i].codeSize;
    return 0;
}

static void report(
    const char *path, VkPipeline pipeline, const VkPipelineShaderStageCreateInfo *stages, const VkShaderModuleCreateInfo *modules,
    uint32_t stage_count) {
    uint32_t workgroup = workgroup_size(&stages[0], &modules[0]);
    PFN_vkGetPipelineExecutablePropertiesKHR get =
        (PFN_vkGetPipelineExecutablePropertiesKHR)vkGetDeviceProcAddr(device, "vkGetPipelineExecutablePropertiesKHR");
    VkPipelineInfoKHR of = {.sType = VK_STRUCTURE_TYPE_PIPELINE_INFO_KHR, .pipeline = pipeline};
    uint32_t count = 0;
    get(device, &of, &count, NULL);
    VkPipelineExecutablePropertiesKHR *executables = calloc(count + 1, sizeof *executables);
    for (uint32_t i = 0; i < count; i++)
        executables[i].sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_PROPERTIES_KHR;
    get(device, &of, &count, executables);

    // NAME-HASH.pipeline, as the layer names files.
    int length = (int)strlen(path) - (int)strlen("-00000000.pipeline");
    char name[4096];
    snprintf(name, sizeof name, "%.*s", length > 0 ? length : 0, path);
    for (uint32_t i = 0; i < count; i++) {
        VkPipelineExecutableInfoKHR which = {
            .sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_INFO_KHR, .pipeline = pipeline, .executableIndex = i};
        const char *stage = stage_name(executables[i].stages);
        printf("{\"device\":");
        print_string(device_name);
        printf(",\"name\":");
        print_string(name);
        printf(",\"hash\":\"%.8s\",\"stage\":\"%s\",\"executable\":", path + strlen(name) + 1, stage);
        print_string(executables[i].name);
        printf(",\"spirv\":%zu,\"workgroup\":%u,\"subgroup\":%u", spirv_size(executables[i].stages, stages, modules, stage_count),
               workgroup, executables[i].subgroupSize);
        print_statistics(&which);
        puts("}");
        if (text_folder)
            write_texts(path, stage, &which);
    }
    fflush(stdout);
    free(executables);
}

int main(int argc, char **argv) {
    if (argc == 3 && !strcmp(argv[1], "--text")) {
        text_folder = argv[2];
    } else if (argc > 1) {
        fprintf(stderr, "usage: replay [--text FOLDER] <paths\n");
        return 2;
    }
    make_device();
    int failed = 0;
    char path[4096];
    while (fgets(path, sizeof path, stdin)) {
        path[strcspn(path, "\n")] = 0;
        Recipe recipe = read_recipe(path);
        VkPipelineShaderStageCreateInfo *stages = NULL;
        VkShaderModuleCreateInfo *modules = NULL;
        uint32_t count = 0;
        VkPipeline pipeline = recipe.size ? make_pipeline(&recipe, &stages, &modules, &count) : NULL;
        if (pipeline) {
            report(path, pipeline, stages, modules, count);
            vkDestroyPipeline(device, pipeline, NULL);
        } else {
            fprintf(stderr, "isa: could not be made: %s\n", path);
            failed = 1;
        }
        for (uint32_t i = 0; i < count; i++) {
            if (text_folder)
                write_text(path, stage_name(stages[i].stage), "spv", modules[i].pCode, modules[i].codeSize);
            vkDestroyShaderModule(device, stages[i].module, NULL);
        }
        free(recipe.bytes); // small things are left: they end with the process
    }
    return failed;
}
