/* Functions of a shared library that is loaded when the first of them is called (core/base/process/late_library.h). Each
   jumps through its slot; while that is empty, by way of SkyquiltLateFunction, with every register an argument may
   lie in kept. System V ABI, x86_64. */

#define LATE_IBT_AND_SHSTK 3

    .macro LATE_LIBRARY library, soname, count
    .section .rodata.str1.1, "aMS", @progbits, 1
late_soname_\library:
    .asciz "\soname"
    .section .bss, "aw", @nobits
    .balign 8
late_slots_\library:
    .zero 8 * \count
    .section .data.rel.ro, "aw"
    .balign 8
late_table_\library:
    .quad late_soname_\library, late_names_\library, late_slots_\library
late_names_\library:
    .endm

    .macro LATE_FUNCTION library, index, name
    .section .rodata.str1.1, "aMS", @progbits, 1
late_name_\library\()_\index:
    .asciz "\name"
    .section .data.rel.ro, "aw"
    .quad late_name_\library\()_\index
    .text
    .weak \name
    .hidden \name
    .type \name, @function
    .balign 16
\name:
    endbr64
    movq late_slots_\library + 8 * \index(%rip), %r11
    testq %r11, %r11
    je 1f
    jmp *%r11
1:  pushq $\index
    leaq late_table_\library(%rip), %r11
    jmp late_first_call
    .size \name, . - \name
    .endm

    .text
    .type late_first_call, @function
late_first_call:
    pushq %rax
    pushq %rdi
    pushq %rsi
    pushq %rdx
    pushq %rcx
    pushq %r8
    pushq %r9
    pushq %r10
    subq $128, %rsp
    movups %xmm0, (%rsp)
    movups %xmm1, 16(%rsp)
    movups %xmm2, 32(%rsp)
    movups %xmm3, 48(%rsp)
    movups %xmm4, 64(%rsp)
    movups %xmm5, 80(%rsp)
    movups %xmm6, 96(%rsp)
    movups %xmm7, 112(%rsp)
    movq %r11, %rdi
    movq 192(%rsp), %rsi
    call SkyquiltLateFunction@PLT
    movq %rax, %r11
    movups (%rsp), %xmm0
    movups 16(%rsp), %xmm1
    movups 32(%rsp), %xmm2
    movups 48(%rsp), %xmm3
    movups 64(%rsp), %xmm4
    movups 80(%rsp), %xmm5
    movups 96(%rsp), %xmm6
    movups 112(%rsp), %xmm7
    addq $128, %rsp
    popq %r10
    popq %r9
    popq %r8
    popq %rcx
    popq %rdx
    popq %rsi
    popq %rdi
    popq %rax
    addq $8, %rsp
    jmp *%r11
    .size late_first_call, . - late_first_call

    .section .note.GNU-stack, "", @progbits
    .section .note.gnu.property, "a"
    .balign 8
    .long 4, 16, 5
    .asciz "GNU"
    .long 0xc0000002, 4, LATE_IBT_AND_SHSTK, 0
