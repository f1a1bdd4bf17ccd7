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
    .section late_tables, "aw"  /* late_library.cc walks them all */
    .balign 8
    .quad late_table_\library
    .section .data.rel.ro, "aw"
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
    .cfi_startproc
    endbr64
    movq late_slots_\library + 8 * \index(%rip), %r11
    testq %r11, %r11
    je 1f
    jmp *%r11
1:  pushq $\index
    .cfi_adjust_cfa_offset 8
    leaq late_table_\library(%rip), %r11
    jmp late_first_call
    .cfi_endproc
    .size \name, . - \name
    .endm

    .text
    .type late_first_call, @function
late_first_call:
    .cfi_startproc
    .cfi_adjust_cfa_offset 8  /* the index */
    pushq %rax
    .cfi_adjust_cfa_offset 8
    pushq %rdi
    .cfi_adjust_cfa_offset 8
    pushq %rsi
    .cfi_adjust_cfa_offset 8
    pushq %rdx
    .cfi_adjust_cfa_offset 8
    pushq %rcx
    .cfi_adjust_cfa_offset 8
    pushq %r8
    .cfi_adjust_cfa_offset 8
    pushq %r9
    .cfi_adjust_cfa_offset 8
    pushq %r10
    .cfi_adjust_cfa_offset 8
    subq $128, %rsp
    .cfi_adjust_cfa_offset 128
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
    .cfi_adjust_cfa_offset -128
    popq %r10
    .cfi_adjust_cfa_offset -8
    popq %r9
    .cfi_adjust_cfa_offset -8
    popq %r8
    .cfi_adjust_cfa_offset -8
    popq %rcx
    .cfi_adjust_cfa_offset -8
    popq %rdx
    .cfi_adjust_cfa_offset -8
    popq %rsi
    .cfi_adjust_cfa_offset -8
    popq %rdi
    .cfi_adjust_cfa_offset -8
    popq %rax
    .cfi_adjust_cfa_offset -8
    addq $8, %rsp
    .cfi_adjust_cfa_offset -8
    jmp *%r11
    .cfi_endproc
    .size late_first_call, . - late_first_call

    .section .note.GNU-stack, "", @progbits
    .section .note.gnu.property, "a"
    .balign 8
    .long 4, 16, 5
    .asciz "GNU"
    .long 0xc0000002, 4, LATE_IBT_AND_SHSTK, 0
